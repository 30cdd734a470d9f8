"""What several commands share: options, a gait from degrees, answers in JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from .model import Gait

AS_JSON = click.option("--json", "as_json", is_flag=True, help="Answer with JSON.")


def gait_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that fix a gait."""
    options = [
        click.option("--alpha-deg", type=float, required=True, help="Amplitude of the joints."),
        click.option("--beta-deg", type=float, required=True, help="Phase lag joint to joint."),
        click.option("--omega-rad-s", type=float, help="Angular rate; or give --frequency-hz."),
        click.option("--frequency-hz", type=float, help="Gait frequency."),
        click.option("--offset-deg", type=float, default=0.0, help="Bend of every joint: steers."),
    ]  # fmt: skip
    for option in reversed(options):
        command = option(command)
    return command


def make_gait(given: dict[str, Any]) -> Gait:
    """Take a gait from degrees and either rate or frequency."""
    from .model import Gait

    omega, frequency = given.pop("omega_rad_s"), given.pop("frequency_hz")
    if (omega is None) == (frequency is None):
        raise click.UsageError("give one of --omega-rad-s and --frequency-hz")
    alpha, beta, offset = (math.radians(given.pop(f"{n}_deg")) for n in ("alpha", "beta", "offset"))
    return Gait(alpha, beta, omega if omega is not None else 2 * math.pi * frequency, offset)


def describe(gait: Gait) -> dict[str, float]:
    """Return a gait as it is typed."""
    return {
        "alpha_deg": math.degrees(gait.alpha_rad),
        "beta_deg": math.degrees(gait.beta_rad),
        "omega_rad_s": gait.omega_rad_s,
        "offset_deg": math.degrees(gait.offset_rad),
    }


def finite(values: Any) -> Any:
    """Return plain values with everything that is not finite as None, for strict JSON."""
    if isinstance(values, dict):
        return {key: finite(value) for key, value in values.items()}
    if isinstance(values, (list, tuple)):
        return [finite(value) for value in values]
    if isinstance(values, float) and not math.isfinite(values):
        return None
    return values


def show_json(values: dict[str, Any]) -> None:
    """Print strict JSON; what is not finite becomes null."""
    click.echo(json.dumps(finite(values), indent=2, allow_nan=False))
