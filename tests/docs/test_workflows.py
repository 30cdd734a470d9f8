"""Workflows and devcontainer: they parse, run what exists, and say that they are untried there."""

from __future__ import annotations

import json
import re
import shutil
import subprocess

import pytest
import yaml
from docs.documents import ROOT

WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
CONTAINER = ROOT / ".devcontainer" / "devcontainer.json"
TARGETS = set(re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))


def unknown(commands: str) -> list[str]:
    """Return the scripts and make targets that a shell command names and that do not exist."""
    scripts = [s for s in re.findall(r"(?<![\w/.])(\.ci/\w+)", commands) if not (ROOT / s).exists()]
    return scripts + [t for t in re.findall(r"\bmake ([\w-]+)", commands) if t not in TARGETS]


def test_there_are_some() -> None:
    assert [path.stem for path in WORKFLOWS] == ["tests", "wheels"]


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
def test_a_workflow_is_whole(path) -> None:
    text = path.read_text()
    assert "Not yet run on a hosted runner" in text.split("name:")[0]
    found = yaml.safe_load(text)
    assert found["name"] == path.stem
    assert True in found  # YAML 1.1 reads the key `on` as true
    assert "permissions" in found
    for job in found["jobs"].values():
        assert set(job.get("needs", [])) <= set(found["jobs"])
        for step in job["steps"]:
            assert ("uses" in step) != ("run" in step), step
            assert re.fullmatch(r"[\w-]+/[\w-]+@[\w./]+", step.get("uses", "a/b@v1")), step
            assert not unknown(step.get("run", ""))


def test_the_devcontainer_runs_what_exists() -> None:
    found = json.loads(CONTAINER.read_text())
    assert re.fullmatch(r"[\w./-]+:[\w.]+", found["image"])
    assert "make build" in found["postCreateCommand"]
    assert not unknown(found["postCreateCommand"])


def test_actionlint_finds_nothing() -> None:
    program = shutil.which("actionlint")
    if program is None:
        pytest.skip(
            "needs actionlint: go install github.com/rhysd/actionlint/cmd/actionlint@v1.7.7"
        )
    done = subprocess.run(
        [program, "-no-color", *WORKFLOWS], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout
