"""Names say what they hold; a statement assigns once; a comprehension has one loop."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
# Prepositions, adverbs and participles: a reader cannot tell from one of them what it holds.
NO_NOUN = re.compile(
    "after|again|ahead|alike|alone|asked|at|away|back|before|both|by|down|each|every|far|few|found"
    "|from|given|heard|held|here|kept|known|late|least|left|made|meant|most|near|now|of|off|one"
    "|other|others|out|over|own|rest|said|seen|soon|still|taken|there|to|told|under|up|wanted"
    "|whole|with",
    re.IGNORECASE,
)
NAMED = {ast.Name: "id", ast.arg: "arg", ast.FunctionDef: "name", ast.ClassDef: "name"}
COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
# Of C++ what is no code, and a name that is no member of another one's.
SKIPPED = re.compile(r'//[^\n]*|/\*.*?\*/|#include[^\n]*|"(?:\\.|[^"\\\n])*"', re.DOTALL)
CPP_NAME = re.compile(r"(?<![\w.>:])[a-z]\w*")


def python_faults(text: str) -> Iterator[tuple[int, str]]:
    """Yield line and name of what is no noun, and of statements that do two things.

    Fields of a class are public names and keys of JSON, which keep theirs: they are not looked at.
    """
    tree = ast.parse(text)
    classes = [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
    parts = chain.from_iterable(node.body for node in classes)
    fields = {id(part.target) for part in parts if isinstance(part, ast.AnnAssign)}
    for node in ast.walk(tree):
        name = getattr(node, NAMED.get(type(node), ""), "")
        is_bound = not isinstance(node, ast.Name) or isinstance(node.ctx, ast.Store)
        if is_bound and id(node) not in fields and NO_NOUN.fullmatch(name.strip("_")):
            yield node.lineno, name
        if isinstance(node, ast.Assign) and len(node.targets) > 1:
            yield node.lineno, "two assignments"
        if isinstance(node, COMPREHENSIONS) and len(node.generators) > 1:
            yield node.lineno, "two loops"


def cpp_faults(text: str) -> Iterator[tuple[int, str]]:
    """Yield line and name of what is no noun."""
    code = SKIPPED.sub(lambda match: "\n" * match[0].count("\n"), text)
    for match in CPP_NAME.finditer(code):
        if NO_NOUN.fullmatch(match[0].strip("_")):
            yield code.count("\n", 0, match.start()) + 1, match[0]


@pytest.mark.parametrize("folder", ["host", "firmware", "studies", "docs"])
def test_names_say_what_they_hold(folder: str) -> None:
    faults = []
    for path in sorted((ROOT / folder).rglob("*")):
        if path.suffix in (".py", ".h", ".hpp", ".cpp"):
            find = python_faults if path.suffix == ".py" else cpp_faults
            name = path.relative_to(ROOT).as_posix()
            faults += [f"{name}:{line}: {fault}" for line, fault in find(path.read_text())]
    assert faults == []
