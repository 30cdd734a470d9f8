"""The weight of the rooms in tokens of code: a row may only fall."""

from __future__ import annotations

import io
import re
import subprocess
import tokenize
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
# Rooms weighed together -> most tokens. A row rises only where another falls as much in the
# same commit. Code that moves into strings, data, docs or another suffix counts where it goes.
MOST_TOKENS = {
    (".",): 0,
    ("calibration_data",): 383,
    ("docs",): 15413,
    ("firmware",): 23552,
    ("host",): 1099,
    ("host/core",): 89900,
    ("host/serpenoid", "host/serpenoid/_core"): 767,
    ("host/serpenoid/base", "host/serpenoid/model"): 12996,
    ("host/serpenoid/simulation",): 10531,
    ("host/serpenoid/periodic",): 6500,
    ("host/serpenoid/gaits",): 6024,
    ("host/serpenoid/servos",): 5606,
    ("host/serpenoid/robot",): 16558,
    ("host/serpenoid/session", "host/serpenoid/friction", "host/serpenoid/taking"): 44639,
    ("host/serpenoid/prediction",): 7480,
    ("host/serpenoid/lab",): 4063,
    ("host/serpenoid/video",): 16628,
    ("host/serpenoid/show",): 14755,
    ("host/serpenoid/commands",): 16052,
    ("host/serpenoid/bench",): 6851,
    ("host/serpenoid/paper",): 1712,
    ("studies",): 8642,
    ("tests",): 149297,
}
PYTHON = (".py", ".pyi")
OTHER = (".c", ".cpp", ".h", ".hpp", ".js", ".html", ".css", ".sh", ".svg")
# What `docs/figures.py` draws into host/docs is no code, whatever its suffix.
DRAWN = re.compile(r"host/docs/.*\.svg")
# In `host/serpenoid` each folder is a room; elsewhere the first folder is one.
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
    return len(_TOKEN.findall(_COMMENT.sub(lambda match: match.group(1) or " ", text)))


def room_of(name: str) -> str:
    """Return the room of a tracked file: `firmware`, `host/core`, `host/serpenoid/show`."""
    parts = Path(name).parts[:-1]
    depth = {"host/serpenoid": 3, "host/core": 2}.get("/".join(parts[:2]), 1)
    return "/".join(parts[:depth]) or "."


def listed() -> list[str]:
    """Return all files that git knows or would add."""
    command = ["git", "-C", ROOT, "ls-files", "-co", "--exclude-standard"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()


def weights() -> dict[str, int]:
    """Return the tokens of each room."""
    tokens: dict[str, int] = {}
    for name in listed():
        if DRAWN.fullmatch(name) or not (ROOT / name).is_file():
            continue
        if Path(name).suffix in PYTHON + OTHER:
            count = python_tokens if name.endswith(PYTHON) else other_tokens
            room = room_of(name)
            tokens[room] = tokens.get(room, 0) + count((ROOT / name).read_text())
    return tokens


pytestmark = pytest.mark.skipif(
    not (ROOT / ".git").exists(), reason="needs a system with git's list of files"
)


def test_no_folder_of_a_trial_slips_in() -> None:
    rooms = {name.partition("/")[0] for name in listed() if "/" in name}
    hidden = {".ci", ".devcontainer", ".github"}
    folders = {"calibration_data", "constraints", "docs", "firmware", "host", "studies", "tests"}
    assert rooms == hidden | folders


def row_weights() -> dict[tuple[str, ...], int]:
    """Return the tokens of each row of MOST_TOKENS; a room without a row is a row of its own."""
    tokens = weights()
    rows = {row: sum(tokens.pop(room, 0) for room in row) for row in MOST_TOKENS}
    return rows | {(room,): count for room, count in tokens.items()}


def test_no_row_is_heavier_than_its_limit() -> None:
    tokens = row_weights()
    assert set(tokens) == set(MOST_TOKENS), "every room has a row"
    heavy = {row: (n, MOST_TOKENS[row]) for row, n in tokens.items() if n > MOST_TOKENS[row]}
    assert not heavy, f"rooms: (tokens, their row): {heavy}"


def test_tokens_are_counted_without_comments_and_docstrings() -> None:
    assert python_tokens('"""Job."""\n# why\nx = f"{1 + 2} m"  # seconds\n') == 3
    assert other_tokens("// job\nint x = 1; /* why */\n") == 5


if __name__ == "__main__":  # print the table of today
    for row, count in row_weights().items():
        print(f"    {row}: {count},".replace("'", '"'))
