"""Every command and every example that a document, a docstring or a message tells to type works."""

from __future__ import annotations

import fnmatch
import os
import re
import shlex
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from coverage_floor import CASES, drawn_person, floor_setup
from docs.documents import PAGES, ROOT, blocks, mentioned, typed, unknown
from serpenoid.base.toml_table import tomllib
from serpenoid.commands.demo import take_session
from serpenoid.session.journal import Journal
from serpenoid.taking.new_session import create_session, default_setup
from serpenoid.taking.simulated import take_all

PACKAGE = ROOT / "host" / "serpenoid"
EXAMPLES = sorted((ROOT / "host" / "examples").glob("*"))
# Tried elsewhere, as they take a board, a person or long; here they are asked for their help.
ELSEWHERE = (
    *("flash", "trim", "monitor", "ports", "doctor", "calibrate"),
    *("bench", "figures", "demo"),
)
TRIED: set[str] = set()


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_commands_of_a_page_exist(page) -> None:
    lines = [*typed(page), *mentioned(page.read_text())]
    assert [why for line in lines if (why := unknown(line))] == []


def test_commands_in_docstrings_messages_and_examples_exist() -> None:
    wrong = []
    for path in [*PACKAGE.rglob("*.py"), *EXAMPLES, ROOT / "Makefile"]:
        if path.is_file():
            lines = mentioned(path.read_text()) + re.findall(
                r"^#\s+(serpenoid .*)$", path.read_text(), re.M
            )
            wrong += [f"{path.name}: {why}" for line in lines if (why := unknown(line))]
    assert wrong == []


def test_make_targets_that_are_named_exist() -> None:
    makefile = (ROOT / "Makefile").read_text()
    targets = set(re.search(r"^\.PHONY: (.*)$", makefile, re.M)[1].split())
    for page in PAGES:
        text = page.read_text()
        named = re.findall(r"`make ([\w-]+)`", text) + re.findall(r"^ {4}make ([\w-]+)", text, re.M)
        assert set(named) <= targets, page.name


def test_every_key_of_json_has_a_meaning() -> None:
    """The keys as they stand in the list of promises, table by table."""
    meanings = tomllib.loads((ROOT / "docs" / "json_keys.toml").read_text())
    promised = (ROOT / "tests" / "golden" / "public.txt").read_text()
    answers = "".join(re.findall(r"^# JSON: .*\n((?:.+\n)+)", promised, re.M))
    keys = re.findall(r"^(?:top|(.+)): (.+)$", answers.replace("[]", ""), re.M)
    known = re.compile("|".join(fnmatch.translate(key.replace("[]", "")) for key in meanings))
    names = {f"{table}.{name}".lstrip(".") for table, row in keys for name in row.split()}
    assert len(names) > 200
    assert [name for name in sorted(names) if not known.match(name)] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_paths_that_a_page_names_are_there(page) -> None:
    text = re.sub(r"\]\([^)]*\)|https?://\S+", "", page.read_text())
    folders = "host|studies|tests|firmware|docs|calibration_data|constraints|\\.ci|\\.github"
    named = re.findall(rf"(?<![\w/.-])((?:{folders})/[\w./-]*\w)", text)
    assert [name for name in named if not (ROOT / name).exists()] == []


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_commands_of_a_page_work(page, folder) -> None:
    for line in typed(page):
        if line not in TRIED:  # on an earlier page
            done = run(runnable(line, folder), folder)
            assert done.returncode == 0, f"{line}\n{done.stderr}"
            TRIED.add(line)


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_python_of_a_page_works(page, folder) -> None:
    for body in blocks(page, "python"):
        done = run([sys.executable, "-c", body], folder)
        assert done.returncode == 0, f"{body}\n{done.stderr}"


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Return a folder that has what a clone's top has, to read from and to fill."""
    clone = tmp_path_factory.mktemp("clone")
    for name in ("host", "tests"):
        (clone / name).symlink_to(ROOT / name)
    shutil.copytree(ROOT / "calibration_data", clone / "calibration_data")
    take_session(clone / "my-robot")
    _push_along_floor(clone / "my-floor")
    return clone


def _push_along_floor(clone: Path) -> None:
    """Take a session of pushes and filmed crawls, by the plan, in the lab."""
    filmed = CASES[0]
    setup, planned = floor_setup(filmed), default_setup("a floor").plan.gaits
    create_session(clone, replace(setup, plan=replace(setup.plan, gaits=planned)))
    with Journal(clone) as journal:
        take_all(journal, drawn_person(filmed, np.random.default_rng(1)))


def runnable(line: str, folder: Path) -> list[str]:
    """Return a command line's words, without what needs a board, hours or a person.

    A recording that an earlier page made in `folder` goes.
    """
    words = shlex.split(line)
    if words[1] in ELSEWHERE:
        return [*words[:2], "--help"]
    if words[1] == "drive":
        words = [w for w in words if w not in ("--port", "virtual")]
        words += ["--port", "virtual:fast"]
        if "--duration-s" not in words:
            words += ["--duration-s", "0.5"]
        if "--record" in words:
            (folder / words[words.index("--record") + 1]).unlink(missing_ok=True)
    return words


def run(words: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    beside = Path(sys.executable).parent
    environment = os.environ | {"PATH": f"{beside}:{os.environ['PATH']}", "MPLBACKEND": "agg"}
    return subprocess.run(
        words,
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=1800,
    )
