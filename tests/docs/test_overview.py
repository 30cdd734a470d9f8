"""Every name that CODE_OVERVIEW.md and CONTRIBUTING.md walk by exists in the code."""

from __future__ import annotations

import ast
import re
from functools import cache

import pytest
from docs.documents import ROOT

SOURCES = ("host/serpenoid", "host/core", "firmware", "tests")
IDENTIFIER = re.compile(r"[A-Za-z_]\w*(?:(?:\.|::)[A-Za-z_]\w*)*")
# Words in backticks that are no names in the code: options of a run, fields on the wire, make's.
NOT_NAMES = {"serpenoid", "slow", "uv", "platformio.ini", "readings.csv", "more"}


@cache
def defined() -> frozenset[str]:
    """Return every name that Python or C++ defines here; `Class.method` and `Class::method` too."""
    names: set[str] = set()
    for folder in SOURCES:
        for path in (ROOT / folder).rglob("*.py"):
            names |= python_names(ast.parse(path.read_text()))
        for path in (ROOT / folder).rglob("*.[ch]*"):
            if path.suffix in (".cpp", ".hpp", ".h"):
                names |= cpp_names(path.read_text())
    return frozenset(names)


def python_names(tree: ast.AST, owner: str = "") -> set[str]:
    names: set[str] = set()
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            names |= {node.name, f"{owner}{node.name}"}
            if isinstance(node, ast.ClassDef):
                names |= python_names(node, f"{node.name}.")
        elif isinstance(node, (ast.Assign, ast.AnnAssign)):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            found = {t.id for t in targets if isinstance(t, ast.Name)}
            names |= found | {f"{owner}{name}" for name in found}
    return names


def cpp_names(text: str) -> set[str]:
    kinds = set(re.findall(r"\b(?:class|struct|enum class)\s+(\w+)", text))
    called = re.findall(r"\b((?:\w+::)?~?\w+)(?=\([^;{}]*\)[\w\s]*(?::[^;{]*)?\{)", text)
    return kinds | set(called) | {name.split("::")[-1] for name in called}


def told(page: str) -> list[str]:
    text = re.sub(r"^```.*?^```", "", (ROOT / page).read_text(), flags=re.M | re.S)
    words = re.findall(r"`([^`\n]+)`", text)
    return [w for w in words if IDENTIFIER.fullmatch(w) and w not in NOT_NAMES]


@pytest.mark.parametrize("page", ["CODE_OVERVIEW.md", "CONTRIBUTING.md"])
def test_every_name_exists(page) -> None:
    files = {path.stem for folder in SOURCES for path in (ROOT / folder).rglob("*.?pp")}
    assert [name for name in told(page) if name not in defined() | files] == []
    assert len(told(page)) > 5
