"""Who may import whom: the arrows between the package's modules."""

from __future__ import annotations

import ast
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2] / "host" / "serpenoid"
SIMULATOR = {"model", "dynamics", "scene", "stability", "simulation", "steady", "optimize"}
COMMAND_LINE = {"cli", "demo", "plot", "plot_run", "report", "run_report", "simulate_command"}
NOT_FOR_THE_SIMULATOR = {"robot", "session", "friction", "plot", "report", "cli", "demo"}


def imports(path: Path) -> set[str]:
    """Return the package's own modules that a file imports, at the top or inside functions."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level:
            found |= {node.module.split(".")[0]} if node.module else {a.name for a in node.names}
    return found


def test_the_simulator_knows_nothing_of_robot_session_or_plot() -> None:
    for name in SIMULATOR:
        assert not imports(PACKAGE / f"{name}.py") & NOT_FOR_THE_SIMULATOR, name


def test_model_imports_nothing_of_ours_but_the_core_and_errors() -> None:
    assert imports(PACKAGE / "model.py") <= {"_core", "errors"}
    assert imports(PACKAGE / "errors.py") == set()


def test_plot_and_report_are_for_the_command_line_alone() -> None:
    for path in PACKAGE.rglob("*.py"):
        if path.stem not in COMMAND_LINE and "_figure" not in path.stem:
            assert not imports(path) & {"plot", "report"}, path.name


def test_nobody_imports_the_command_line() -> None:
    for path in PACKAGE.rglob("*.py"):
        assert "cli" not in imports(path), path.name
