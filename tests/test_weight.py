"""The weight of each room in tokens of code: a row may only fall."""

from __future__ import annotations

import io
import re
import subprocess
import tokenize
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
# Room -> most tokens. A row rises only where another falls as much in the same commit. Code that
# moves into strings, data, generated files, docs or another suffix counts where it goes.
MOST_TOKENS = {
    "calibration_data": 388,
    "docs": 24184,
    "firmware": 23397,
    "host": 1109,
    "host/core/board": 1069,
    "host/core/body": 2171,
    "host/core/drive": 2999,
    "host/core/lab": 4920,
    "host/core/methods": 20159,
    "host/core/model": 5956,
    "host/core/numerics": 13618,
    "host/core/periodic": 28228,
    "host/core/python": 7561,
    "host/core/run": 2946,
    "host/core/scene": 9031,
    "host/core/servos": 8366,
    "host/core/web": 1326,
    "host/serpenoid": 794,
    "host/serpenoid/_core": 2865,
    "host/serpenoid/base": 1639,
    "host/serpenoid/bench": 10944,
    "host/serpenoid/calibration": 73831,
    "host/serpenoid/commands": 23197,
    "host/serpenoid/gaits": 8567,
    "host/serpenoid/lab": 5807,
    "host/serpenoid/model": 12784,
    "host/serpenoid/paper": 2483,
    "host/serpenoid/periodic": 9085,
    "host/serpenoid/prediction": 12315,
    "host/serpenoid/robot": 18477,
    "host/serpenoid/servos": 7971,
    "host/serpenoid/show": 20973,
    "host/serpenoid/simulation": 13708,
    "host/serpenoid/video": 23912,
    "studies": 22180,
    "tests": 3662,
    "tests/arm": 1428,
    "tests/avr": 19213,
    "tests/docs": 6577,
    "tests/end_to_end": 1135,
    "tests/firmware": 11073,
    "tests/golden": 3913,
    "tests/host": 771,
    "tests/host/base": 154,
    "tests/host/bench": 1917,
    "tests/host/calibration": 36031,
    "tests/host/commands": 10998,
    "tests/host/gaits": 7663,
    "tests/host/lab": 6828,
    "tests/host/model": 4403,
    "tests/host/paper": 742,
    "tests/host/periodic": 13996,
    "tests/host/prediction": 4098,
    "tests/host/robot": 23253,
    "tests/host/servos": 4164,
    "tests/host/show": 3833,
    "tests/host/simulation": 19247,
    "tests/host/video": 17069,
    "tests/oracle": 14742,
    "tests/portable": 1130,
    "tests/studies": 1553,
}
PYTHON = (".py", ".pyi")
OTHER = (".c", ".cpp", ".h", ".hpp", ".js", ".html", ".css", ".sh", ".svg")
# What `docs/figures.py` draws into host/docs is no code, whatever its suffix.
DRAWN = re.compile(r"host/docs/.*\.svg")
# In `host/serpenoid` and `host/core` each folder is a room; elsewhere the first folder is one.
PARTED = ("host/serpenoid/", "host/core/")
_TOKEN = re.compile(
    r"\"(?:\\.|[^\"\\])*\"|'(?:\\.|[^'\\])*'|[A-Za-z_]\w*|\d[\w.]*"
    r"|::|->|<<|>>|<=|>=|==|!=|&&|\|\||[^\s\w]"
)
_COMMENT = re.compile(
    r"//[^\n]*|/\*.*?\*/|<!--.*?-->|(\"(?:\\.|[^\"\\])*\"|'(?:\\.|[^'\\])*')", re.DOTALL
)
_SKIPPED = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENCODING,
    tokenize.ENDMARKER,
}
# From Python 3.12 on an f-string is several tokens; it counts as one, as before.
_F_START, _F_END = (getattr(tokenize, f"FSTRING_{end}", None) for end in ("START", "END"))


def python_tokens(text: str) -> int:
    """Count tokens; a string that is a statement of its own (a docstring) counts nothing."""
    count, starts_statement, f_strings = 0, True, 0
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type in _SKIPPED:
            layout = (tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT)
            starts_statement = starts_statement or token.type in layout
        elif _F_END is not None and token.type == _F_END:
            f_strings -= 1
        else:
            docstring = starts_statement and token.type == tokenize.STRING
            count += not f_strings and not docstring
            f_strings += _F_START is not None and token.type == _F_START
            starts_statement = False
    return count


def other_tokens(text: str) -> int:
    """Count tokens of C++, JavaScript, a page or a script."""
    return len(_TOKEN.findall(_COMMENT.sub(lambda found: found.group(1) or " ", text)))


def room_of(name: str) -> str:
    """Return the room of a tracked file: `firmware`, `host/core/body`, `tests/host/show`."""
    parts = Path(name).parts[:-1]
    depth = 3 if name.startswith((*PARTED, "tests/host/")) else 2 if parts[:1] == ("tests",) else 1
    return "/".join(parts[:depth]) or "."


def listed() -> list[str]:
    """Return all files that git knows or would add."""
    command = ["git", "-C", ROOT, "ls-files", "-co", "--exclude-standard"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()


def weights() -> dict[str, int]:
    """Return the tokens of each room."""
    found: dict[str, int] = {}
    for name in listed():
        if DRAWN.fullmatch(name) or not (ROOT / name).is_file():
            continue
        if Path(name).suffix in PYTHON + OTHER:
            count = python_tokens if name.endswith(PYTHON) else other_tokens
            room = room_of(name)
            found[room] = found.get(room, 0) + count((ROOT / name).read_text())
    return found


pytestmark = pytest.mark.skipif(
    not (ROOT / ".git").exists(), reason="needs a system with git's list of files"
)


def test_no_folder_of_a_trial_slips_in() -> None:
    rooms = {name.partition("/")[0] for name in listed() if "/" in name}
    hidden = {".ci", ".devcontainer", ".github"}
    kept = {"calibration_data", "constraints", "docs", "firmware", "host", "studies", "tests"}
    assert rooms == hidden | kept


def test_no_room_outgrows_its_row() -> None:
    found = weights()
    assert set(found) <= set(MOST_TOKENS), "every room has a row"
    heavy = {room: (n, MOST_TOKENS[room]) for room, n in found.items() if n > MOST_TOKENS[room]}
    assert not heavy, f"room: (tokens, its row): {heavy}"


def test_tokens_are_counted_without_comments_and_docstrings() -> None:
    assert python_tokens('"""Job."""\n# why\nx = f"{1 + 2} m"  # seconds\n') == 3
    assert other_tokens("// job\nint x = 1; /* why */\n") == 5


if __name__ == "__main__":  # print the table of today
    for room, count in sorted(weights().items()):
        print(f'    "{room}": {count},')
