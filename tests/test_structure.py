"""The house: which rooms there are, that arrows run down only, and no circles."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "host" / "serpenoid"
CORE = ROOT / "host" / "core"
# From the ground up: a file imports from its own room and from rooms named before it.
ROOMS = [
    "base",
    "model",
    "servos",
    "periodic",
    "simulation",
    "gaits",
    "paper",
    "robot",
    "lab",
    "session",
    "friction",
    "taking",
    "prediction",
    "video",
    "show",
    "bench",
    "commands",
]
CORE_ROOMS = [
    "numerics",
    "model",
    "drive",
    "body",
    "lab",
    "scene",
    "methods",
    "run",
    "periodic",
    "servos",
    "board",
    "web",
    "python",
]
# Rooms that see less than all that is below them: name -> the modules they may import.
NARROW = {
    "lab": r"(lab|servos|simulation|model|base)(\..*)?|robot\.wire\..*",
    "servos": r"(servos|model|base)(\..*)?",
    "taking": r"(taking|session|lab|robot|servos|model|base)(\..*)?",
    "video": r"(video|model|base)(\..*)?|session\.(session|settings)",
}
# Libraries that are slow or optional: name -> the rooms that may import them.
LIBRARIES = {
    "matplotlib": ("show", "bench", "commands", "base"),  # base: the type that `.plot()` returns
    "rich": ("base", "show", "bench", "commands"),
    "cv2": ("video",),
    "av": ("video",),
}
Graph = dict[str, set[str]]


def module_of(path: Path) -> str:
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def python_imports(path: Path, modules: set[str]) -> set[str]:
    """Return the package's own modules that a file imports: anywhere, type checking included."""
    modules_imported = set()
    package = path.relative_to(PACKAGE).parts[:-1]
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = package[: len(package) - node.level + 1]
            source = ".".join([*base, *filter(None, [node.module])])
            for name in node.names:
                inner = f"{source}.{name.name}".strip(".")
                modules_imported.add(inner if inner in modules or not source else source)
    return modules_imported - {module_of(path), "_core", ""}


@cache
def python_graph() -> Graph:
    files = {module_of(path): path for path in PACKAGE.rglob("*.py")}
    return {name: python_imports(path, set(files)) for name, path in files.items()}


@cache
def core_graph() -> Graph:
    """Return source units (a header and its source are one) and the units they include."""
    graph: Graph = {}
    for path in [*CORE.rglob("*.hpp"), *CORE.rglob("*.cpp")]:
        unit = path.relative_to(CORE).with_suffix("").as_posix()
        included = re.findall(r'#include "([\w/]+/\w+)\.hpp"', path.read_text())
        graph.setdefault(unit, set()).update(set(included) - {unit})
    return graph


def circles(graph: Graph) -> list[list[str]]:
    """Return the circles that a depth-first search meets, each as the files in it."""
    loops, done = [], set()

    def visit(name: str, path: list[str]) -> None:
        if name in path:
            loops.append(path[path.index(name) :])
        elif name not in done:
            for other in sorted(graph.get(name, ())):
                visit(other, [*path, name])
            done.add(name)

    for name in sorted(graph):
        visit(name, [])
    return loops


def uphill(graph: Graph, rooms: tuple[str, ...], separator: str) -> list[str]:
    """Return the arrows that run up, and those from or to no known room."""
    floor = {room: k for k, room in enumerate(rooms)}
    wrong = []
    for name, targets in graph.items():
        for target in targets:
            ends = [x.split(separator)[0] for x in (name, target)]
            if not all(x in floor for x in ends) or floor[ends[1]] > floor[ends[0]]:
                wrong.append(f"{name} -> {target}")
    return sorted(wrong)


def inside_rooms(graph: Graph) -> Graph:
    """Leave out the package's face and the extension module, which are in no room."""
    keep = {name for name in graph if name.split(".")[0] in ROOMS}
    return {name: {o for o in graph[name] if not o.startswith("_core")} for name in keep}


def test_arrows_run_down() -> None:
    assert uphill(inside_rooms(python_graph()), ROOMS, ".") == []
    assert uphill(core_graph(), CORE_ROOMS, "/") == []


def test_the_labs_chain_knows_nothing_of_the_products_law() -> None:
    """It has its law and its contacts a second time, so that an error in one of them shows."""
    reached = {o for n, others in core_graph().items() if n.startswith("lab/") for o in others}
    shared = {"drive/servo", "model/params", "numerics/cholesky"}
    assert {o for o in reached if not o.startswith("lab/")} == shared


def test_the_fit_and_the_lab_share_nothing() -> None:
    """What is tested by a world must not be in it, nor the world in what is tested."""
    graph, judged = python_graph(), re.compile(r"(session|friction)\b")
    both = [(name, o) for name, others in graph.items() for o in others]
    assert [(a, b) for a, b in both if judged.match(a) and b.split(".")[0] == "lab"] == []
    assert [(a, b) for a, b in both if a.split(".")[0] == "lab" and judged.match(b)] == []


@pytest.mark.parametrize("graph", [python_graph, core_graph], ids=["python", "core"])
def test_no_circles(graph) -> None:
    assert circles(graph()) == []


@pytest.mark.parametrize("room", NARROW)
def test_narrow_rooms_see_what_they_may(room: str) -> None:
    seen = {o for n, others in python_graph().items() if n.split(".")[0] == room for o in others}
    assert [o for o in sorted(seen) if not re.fullmatch(NARROW[room], o)] == []


def test_every_file_is_in_a_room_that_says_its_job() -> None:
    loose = {p.name for p in PACKAGE.glob("*.py")}
    assert loose == {"__init__.py", "__main__.py"}
    assert {p.name for p in PACKAGE.iterdir() if (p / "__init__.py").exists()} <= set(ROOMS)
    for path in PACKAGE.rglob("*.py"):
        assert ast.get_docstring(ast.parse(path.read_text())), path
    assert {p.name for p in CORE.iterdir()} == {*CORE_ROOMS, "README.md", "CMakeLists.txt"}
    described = re.findall(r"^\| `(\w+)/` \| \w", (CORE / "README.md").read_text(), re.MULTILINE)
    assert described == list(CORE_ROOMS)
    for path in [*CORE.rglob("*.hpp"), *CORE.rglob("*.cpp")]:
        assert path.read_text().startswith("// "), path


@pytest.mark.parametrize("library", LIBRARIES)
def test_a_library_lives_in_its_rooms(library: str) -> None:
    for path in PACKAGE.rglob("*.py"):
        if path.relative_to(PACKAGE).parts[0] not in LIBRARIES[library]:
            line = re.search(rf"^ *(from|import) {library}\b", path.read_text(), re.MULTILINE)
            assert not line, f"{path} imports {library}"
        if library in ("cv2", "av"):  # of the extra: imported where they are used
            assert not re.search(rf"^(from|import) {library}\b", path.read_text(), re.MULTILINE)


# What one gate alone may do: a pattern -> the files that are that gate. A `part` is whole_file's.
GATES = {
    r"(?<!part)\.(open\([^)]*[\"'][wx]b?[\"']|write_(text|bytes)\()": ("base/files.py",),
    r"csv\.(Dict)?[rR]eader\(": ("base/files.py",),
    r"\bav\.open\((?!str\(part\))": ("video/seeing/film.py",),
    r"np\.load\(": ("base/files.py",),
}


@pytest.mark.parametrize("pattern", GATES)
def test_files_pass_one_gate(pattern: str) -> None:
    """Files are read by what checks them first, and written whole or not at all."""
    for path in PACKAGE.rglob("*.py"):
        name = path.relative_to(PACKAGE).as_posix()
        if name not in GATES[pattern]:
            assert not re.search(pattern, path.read_text()), path
