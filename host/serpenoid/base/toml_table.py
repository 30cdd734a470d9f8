"""Read TOML files that people type; a message on a wrong value names its file and line."""

from __future__ import annotations

import difflib
import math
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from .checks import check_number, check_text, check_whole
from .errors import BadInput
from .files import read_text

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib  # pyright: ignore[reportMissingImports]


@dataclass(frozen=True)
class Table:
    """One table of a TOML file; its methods name file and line of a wrong value."""

    values: Mapping[str, Any]
    path: Path
    text: str
    start: int = 0  # position in text just behind the table's heading

    @classmethod
    def load(cls, path: Path) -> Table:
        """Read a whole file as its top table; raises BadInput."""
        text = read_text(path, most_bytes=1_000_000)  # the parser reads some 2 MB a second
        try:
            return cls.parsed(text, path)
        except (ValueError, RecursionError) as error:  # a number of 5000 digits is a ValueError
            raise BadInput(f"{path}: not TOML: {error}") from error

    @classmethod
    def parsed(cls, text: str, path: Path) -> Table:
        """Read the text of the file `path`; raises ValueError if it is not TOML."""
        return cls(tomllib.loads(text), path, text)

    def check_format(self, newest: int, older: str = "") -> None:
        """Raise BadInput unless the file's format is the newest.

        older: the message's words on files of an older format.
        """
        if "format" not in self.values:
            lacks = "has no format" if self.values else "is empty"
            raise BadInput(f"{self.path}: the file {lacks}; it must begin with format = {newest}")
        number = self.integer("format")
        newer = f"; this version of serpenoid reads formats up to {newest}; install a newer one"
        if number != newest:
            what = newer if number > newest else f", {older}"
            raise BadInput(f"{self.where('format')}: format is {number}{what}")

    def where(self, key: str) -> str:
        """Return file and line of a key or of a table's heading."""
        return self._line(self._find(key))

    @property
    def heading(self) -> str:
        """Return file and line of the table's heading; the file alone for its top table."""
        return self._line(self.start)

    def _line(self, position: int) -> str:
        """Return the file and the line of a position in its text; the file alone for 0."""
        if not position:
            return str(self.path)
        return f"{self.path}:{self.text.count(chr(10), 0, position) + 1}"

    def _find(self, key: str) -> int:
        """Return the position in the text where a key or a table's heading ends; 0 if absent."""
        pattern = re.compile(rf"^[ \t]*\[?[ \t]*\"?{re.escape(key)}\"?[ \t]*[=\]]", re.MULTILINE)
        match = pattern.search(self.text, self.start)
        return match.end() if match else 0

    def check_keys(self, *names: str, optional: tuple[str, ...] = ()) -> None:
        """Raise BadInput unless the table has all keys `names`, and no others but optional ones."""
        unknown = next((key for key in self.values if key not in names + optional), "")
        check_names(self.values, names, self.where(unknown), "key", optional)

    def without_removed(self, removed: Mapping[str, str]) -> Table:
        """Return the table without its removed settings.

        removed: key -> advice for its user. A setting of 0 had no effect. With any other value the
        results would change, so it raises BadInput.
        """
        for key, advice in removed.items():
            value = self.values.get(key, 0)
            if any(value) if isinstance(value, list) else value != 0:
                raise BadInput(f"{self.where(key)}: {key} is {value!r}; {advice}")
        values = {key: value for key, value in self.values.items() if key not in removed}
        return replace(self, values=values)

    def table(self, name: str) -> Table:
        """Return the table of that name inside this one."""
        if not isinstance(self.values[name], dict):
            raise BadInput(f"{self.where(name)}: {name} must be a table, [{name}]")
        return Table(self.values[name], self.path, self.text, self._find(name))

    def string(self, name: str) -> str:
        """Return a string that is not blank."""
        with located(self.where(name)):
            return check_text(name, self.values[name])

    def integer(self, name: str) -> int:
        """Return a whole number of 1 or more."""
        with located(self.where(name)):
            return check_whole(name, self.values.get(name), 1)

    def number(self, name: str, low: float = -math.inf, high: float = math.inf) -> float:
        """Return a finite number between the limits."""
        with located(self.where(name)):
            return check_number(name, self.values[name], low, high)

    def numbers(
        self, name: str, low: float = -math.inf, high: float = math.inf
    ) -> tuple[float, ...]:
        """Return a list of one or more finite numbers between the limits."""
        values = self.values[name]
        with located(self.where(name)):
            if not isinstance(values, list) or not values:
                raise BadInput(f"{name} is {values!r}; it must be a list of numbers")
            return tuple(check_number(name, value, low, high) for value in values)


@contextmanager
def located(where: str) -> Iterator[None]:
    """Put file and line before the text of any BadInput raised inside."""
    try:
        yield
    except BadInput as error:
        raise BadInput(f"{where}: {error}") from error


def check_names(
    names: Iterable[str],
    needed: tuple[str, ...],
    where: str,
    what: str,
    optional: tuple[str, ...] = (),
) -> None:
    """Raise BadInput unless all needed names are there, once each, and no others but optional ones.

    where: file and line, or option. what: the word for a name in messages, such as "key".
    """
    names = list(names)
    for name in names:
        if name not in needed + optional:
            allowed = needed + optional
            close = difflib.get_close_matches(name, allowed, n=1)
            hint = f"did you mean {close[0]!r}?" if close else f"known are {', '.join(allowed)}"
            raise BadInput(f"{where}: unknown {what} {name!r}; {hint}")
        if names.count(name) > 1:
            raise BadInput(f"{where}: {what} {name!r} stands there twice")
    missing = [name for name in needed if name not in names]
    if missing:
        raise BadInput(f"{where}: missing {what} {', '.join(missing)}, which has no default")
