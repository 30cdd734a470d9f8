"""Public docstrings have NumPy's sections and name every quantity's unit."""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Iterator

import pytest
import serpenoid as sn
from serpenoid.robot import Robot as Board

# A name's ending, and the word that a docstring has for it.
UNITS = {
    "m": "m",
    "s": "s",
    "rad": "rad",
    "kg": "kg",
    "w": "W",
    "j": "J",
    "n": "N",
    "nm": "N m",
    "hz": "Hz",
    "v": "V",
    "m_s": "m/s",
    "rad_s": "rad/s",
    "rad_s2": "rad/s^2",
    "m_s2": "m/s^2",
    "n_m": "N/m",
    "n_s_m": "N s/m",
    "kg_m2": "kg m^2",
    "nm_rad": "N m/rad",
    "nms_rad": "N m s/rad",
    "rad_per_cycle": "rad",
    "deg": "degrees",
    "us": "us",
}
ENDING = re.compile(rf"_({'|'.join(sorted(UNITS, key=len, reverse=True))})$")
NUMBER = re.compile(r"float|NDArray|Array")
NO_NUMBER = re.compile(r"bool|Callable|LinkState|TorqueTable|^'?Mapping")
PLAIN = (
    "relative",
    "factor",
    "sigma",
    "standard deviation",
    "chance",
    "multiplier",
    "share",
    "less 1",
    "chi2",
    "of the speed",
    "PROTOCOL.md",
)
PUBLIC = {name: getattr(sn, name) for name in sn.__all__ if callable(getattr(sn, name))}
PUBLIC = {n: o for n, o in PUBLIC.items() if not (inspect.isclass(o) and issubclass(o, Exception))}
PUBLIC["robot.Robot"] = Board


def documented(thing: object) -> Iterator[tuple[str, str, str]]:
    """Yield name, annotation and docstring of each field, argument and property."""
    text = inspect.getdoc(thing) or ""
    if not inspect.isclass(thing):
        yield from ((p.name, str(p.annotation), text) for p in parameters(thing))
        return
    if dataclasses.is_dataclass(thing):
        yield from ((f.name, str(f.type), text) for f in dataclasses.fields(thing))
    for name, member in vars(thing).items():
        if name.startswith("_"):
            continue
        if isinstance(member, property):
            kind = inspect.signature(member.fget).return_annotation
            yield name, str(kind), f"{name}: {inspect.getdoc(member)}\n{text}"
        elif isinstance(member, (staticmethod, classmethod)) or inspect.isfunction(member):
            inner = getattr(member, "__func__", member)
            said = inspect.getdoc(inner) or ""
            yield from ((p.name, str(p.annotation), said) for p in parameters(inner))


def parameters(function: object) -> list[inspect.Parameter]:
    found = inspect.signature(function).parameters.values()
    return [p for p in found if p.name not in ("self", "cls")]


def says(text: str, word: str) -> bool:
    return re.search(rf"(?<![\w/]){re.escape(word)}(?![\w/^])", " ".join(text.split())) is not None


def missing(name: str, text: str) -> str:
    """Return what a docstring should say of a quantity and does not; empty if all is there."""
    ending = ENDING.search(name)
    if ending:
        unit = UNITS[ending[1]]
        return "" if says(text, unit) else unit
    at = re.search(rf"\b{name}\b", text)
    if at is None:
        return "its name"
    rest = text[at.start() : at.start() + 200]
    if any(word in rest for word in PLAIN) or any(says(rest, unit) for unit in UNITS.values()):
        return ""
    return "a unit, or that it has none"


@pytest.mark.parametrize("public", PUBLIC)
def test_every_quantity_names_its_unit(public) -> None:
    wrong = []
    for name, kind, text in documented(PUBLIC[public]):
        quantity = NUMBER.search(kind) and not NO_NUMBER.search(kind) and name[0] != "_"
        if quantity and (lacks := missing(name, text)):
            wrong.append(f"{name}: docstring lacks {lacks}")
    assert not wrong, f"{public}: {wrong}"


def entries(text: str, section: str) -> list[str]:
    """Return the names that a section of a docstring explains."""
    body = re.search(
        rf"^{section}\n-+\n(.*?)(?=^\S[^\n]*\n-+\n|\Z)", text, re.DOTALL | re.MULTILINE
    )
    heads = re.findall(r"^\S.*$", body[1], re.MULTILINE) if body else []
    return [name.strip(" *") for head in heads for name in head.partition(" : ")[0].split(",")]


@pytest.mark.parametrize("public", PUBLIC)
def test_docstrings_explain_every_field_and_argument(public) -> None:
    thing = PUBLIC[public]
    text = inspect.getdoc(thing) or ""
    if inspect.isclass(thing):
        fields = dataclasses.fields(thing) if dataclasses.is_dataclass(thing) else ()
        wanted = [f.name for f in fields if not f.name.startswith("_")]
        told = entries(text, "Attributes")
    else:
        wanted = [p.name for p in parameters(thing)]
        told = entries(text, "Parameters")
        returns = inspect.signature(thing).return_annotation
        assert str(returns) == "None" or entries(text, "Returns")
        assert entries(text, "Raises")
    assert not set(wanted) - set(told), public
