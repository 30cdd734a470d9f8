"""The command `serpenoid sweep`: every gait of a grid, of one robot or many."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import click

import serpenoid as sn

from ...show.screen import progress, say
from ..declare import Given, directory, number, option, out_file, radians
from ..options import (
    ALPHA_DEG,
    AS_JSON,
    BETA_DEG,
    GROUND,
    make_robot,
    robot_options,
    servo_option,
    show_json,
    take_servo,
)

SUFFIXES = (".csv", ".npz", ".json")
_MOST = 100_000  # values of a range
_FILE_GAITS, _JSON_GAITS = 20_000_000, 1_000_000  # what memory holds of one file, as arrays or text
_BODY = {"links": "links", "mass_kg": "link_mass_kg", "length_m": "link_length_m"}


def _span(text: str, name: str) -> list[float]:
    """Read FIRST:LAST:STEP, or one number."""
    try:
        numbers = [float(part) for part in text.split(":")]
    except ValueError:
        numbers = []
    if len(numbers) not in (1, 3) or not all(math.isfinite(v) for v in numbers):
        wanted = "FIRST:LAST:STEP, such as 5:75:5, nor one number"
        raise click.BadParameter(f"{text!r} is not {wanted}", param_hint=name)
    if len(numbers) == 1:
        return numbers
    first, last, step = numbers
    if last < first or step <= 0:
        low, high = sorted((first, last))
        way = f"{low:g}:{high:g}:{abs(step) or 1:g}"
        raise click.BadParameter(f"{text!r} must go upwards, such as {way}", param_hint=name)
    if (last - first) / step >= _MOST:
        few = f"{(last - first) / step:.2g} values; the most is {_MOST}: take a larger step"
        raise click.BadParameter(f"{text!r} is {few}", param_hint=name)
    return [first + i * step for i in range(int((last - first) / step + 1 + 1e-9))]


def path(value: str) -> Path:
    """Return a file with a suffix, or a folder for a study."""
    there = Path(value)
    kind = out_file(*SUFFIXES) if there.suffix and not there.is_dir() else directory
    return kind(value)


def _varied(given: tuple[str, ...], fixed: Given) -> dict[str, list[float]]:
    """Read each NAME=FIRST:LAST:STEP; fixed: the robot's other options, None if not given."""
    axes: dict[str, list[float]] = {}
    names = *_BODY, *GROUND.names
    for text in given:
        name, equals, span = text.partition("=")
        if not equals or name not in names:
            raise click.BadParameter(
                f"{text!r} is not NAME=FIRST:LAST:STEP with a NAME of " + ", ".join(names),
                param_hint="--vary",
            )
        if name in axes or fixed[_BODY.get(name, name)] is not None:
            other = "another one" if name in axes else f"--{name.replace('_', '-')}"
            raise click.UsageError(f"--vary {name} and {other} contradict each other; give one")
        axes[name] = _span(span, "--vary")
    return axes


def _each(base: Any, varied: dict[str, list[Any]]) -> Any:
    """Return the base with every combination of the varied fields; alone where none varies."""
    if not varied:
        return base
    ways = product(*varied.values())
    return [replace(base, **dict(zip(varied, values, strict=True))) for values in ways]


@click.command()
@robot_options
@option(
    "--vary",
    "Vary the robot, too: links, mass_kg, length_m, ct, cn, ft0 or fn0 (all per "
    "link). May be given several times; wants a folder as --out.",
    multiple=True,
    metavar="NAME=FIRST:LAST:STEP",
)
@option("--alpha-deg", "FIRST:LAST:STEP.", default="5:75:5")
@option("--beta-deg", "FIRST:LAST:STEP.", default="20:90:5")
@option("--omega-rad-s", "FIRST:LAST:STEP; 1:20:1 unless given.")
@option("--frequency-hz", "FIRST:LAST:STEP, in place of --omega-rad-s.")
@number("--rtol", "Relative accuracy.", default=1e-6)
@servo_option
@option("--threads", "Threads to solve in; one a processor unless given.", type=int)
@option(
    "--scheduler",
    "Solve on the Dask cluster with this address, e.g. tcp://10.0.0.1:8786.",
    metavar="ADDRESS",
)
@option(
    "--out",
    "CSV, npz or JSON file to write; or a folder, filled chunk by chunk and gone on "
    "with if the same is asked for again.",
    type=path,
)
@AS_JSON
def sweep(
    as_json: bool,
    out: Path | None,
    vary: tuple[str, ...],
    alpha_deg: str,
    beta_deg: str,
    omega_rad_s: str | None,
    frequency_hz: str | None,
    rtol: float,
    threads: int | None,
    scheduler: str | None,
    **given: Any,
) -> None:
    """Solve every gait of a grid (the paper's 4500 unless told), into files or as JSON.

    Joints follow the gaits exactly. --servo adds the speed with servos and its 95 % band, at half
    a second a gait; powers stay those of ideal joints.
    """
    if out is None and not as_json:
        raise click.UsageError("give --out FILE.csv, or --json for an answer on the screen")
    whole = out is not None and (out.is_dir() or not out.suffix)
    if vary and not whole:
        raise click.UsageError("--vary writes a study: give --out a folder, without a suffix")
    if whole and as_json:
        raise click.UsageError("--json is for a sweep that fits on a screen; a study is a folder")
    servo = take_servo()
    if whole and servo is not None:
        raise click.UsageError("--servo is for one robot's sweep: give --out a file, or --json")
    varied = _varied(vary, given)
    robot, ground = make_robot(given)
    if frequency_hz is not None and omega_rad_s is not None:
        raise click.UsageError("--omega-rad-s and --frequency-hz say the same; give one")
    alphas_deg, betas_deg = _span(alpha_deg, "--alpha-deg"), _span(beta_deg, "--beta-deg")
    grid = {
        "alpha_rad": [radians("--alpha-deg", a, *ALPHA_DEG) for a in alphas_deg],
        "beta_rad": [radians("--beta-deg", b, *BETA_DEG) for b in betas_deg],
        "omega_rad_s": _span(omega_rad_s or "1:20:1", "--omega-rad-s")
        if frequency_hz is None
        else [2 * math.pi * hz for hz in _span(frequency_hz, "--frequency-hz")],
    }
    how = {"rtol": rtol, "threads": threads, "scheduler": scheduler}
    if out is not None and whole:
        _study(out, robot, ground, varied, grid | how)
    else:
        _one(out, as_json, (robot, ground), grid, how | {"servo": servo})


def _one(
    out: Path | None,
    as_json: bool,
    body: tuple[sn.Robot, sn.Ground],
    grid: dict[str, list[float]],
    how: Given,
) -> None:
    """Solve and write the gaits of one robot."""
    from ...show.sweep_files import sweep_values, write_sweep

    count = math.prod(map(len, grid.values()))
    text = as_json or (out is not None and out.suffix.lower() == ".json")
    if count > (most := _JSON_GAITS if text else _FILE_GAITS):
        raise click.UsageError(
            f"{count:.3g} gaits are too many for {'JSON' if text else 'one file'}, which holds up "
            f"to {most:.3g}; name a folder, --out STUDY, which is filled chunk by chunk"
        )
    with progress(count * (1 if how["servo"] is None else 2), "gaits") as advance:
        grid_states = sn.sweep(*body, **grid, **how, progress=advance)
    if out is not None:
        write_sweep(grid_states, out)
        missed = int((~grid_states.converged).sum())
        say(f"wrote {count} gaits to {out}; {missed} did not converge", err=True)
        if grid_states.servo_speed_m_s is not None:
            lost = sum(map(math.isnan, grid_states.servo_speed_m_s.flat))
            say(f"with servos {lost} do not settle to a speed", err=True)
    if as_json:
        show_json(sweep_values(grid_states))


def _study(
    out: Path,
    robot: sn.Robot,
    ground: sn.Ground,
    varied: dict[str, list[float]],
    how: Given,
) -> None:
    """Solve a study of every robot on every ground into its folder."""
    body: dict[str, list[Any]] = {_BODY[name]: varied[name] for name in _BODY if name in varied}
    grip = {name: varied[name] for name in GROUND.names if name in varied}
    if any(links % 1 for links in body.get("links", ())):
        raise click.BadParameter("links must be whole numbers", param_hint="--vary")
    if "links" in body:
        body["links"] = [int(links) for links in body["links"]]
    if body and robot == replace(robot, link_inertia_kg_m2=None):
        body["link_inertia_kg_m2"] = [None]  # a uniform rod stays one
    lists = [values for values in (*varied.values(), *how.values()) if isinstance(values, list)]
    count = math.prod(map(len, lists))
    with progress(count, "gaits") as advance:
        parts = _each(robot, body), _each(ground, grip)
        study = sn.sweep_study(*parts, out=out, progress=advance, **how)
    missed = sum(int((~chunk["converged"]).sum()) for chunk in study)
    say(
        f"{count} gaits in {len(study.chunks)} chunks in {out}; {missed} did not converge", err=True
    )
