"""Whatever options are combined, what a refusal of `simulate` says to do leads to a run."""

from __future__ import annotations

import random
import re

import pytest
from command_line import serpenoid

CHOICES = {
    "--formulation": ["explicit", "implicit"],
    "--method": [
        "rk4",
        "paper",
        "dop853",
        "radau",
        "nonsmooth",
    ],
    "--dt-s": ["1e-2", "1e-3", "1e-4"],
    "--tolerance": ["1e-6"],
    "--accuracy": ["1e-3", "1e-5"],
    "--record": ["energy", "joints", "friction", "joints,friction,energy"],
    "--incline-deg": ["5"],
    "--servo-fields": [""],
    "--torque-nm": ["0.01,0.01,0,0,0"],
    "--limp": ["2"],
    "--locked-deg": ["1=10"],
    "--stiffness-n-m": ["1e3", "1e6"],
    "--damping-n-s-m": ["1", "100"],
    "--start": ["zero_momentum", "link1_at_rest", "steady"],
    "--gap": ["zero", "slow_manifold"],
    "--record-every": ["10", "100000"],
    "--duration-s": ["0", "0.05"],
    "--offset-deg": ["5"],
    "--ct": ["0.02,0.5"],
}
GAIT = {"--alpha-deg": "30", "--beta-deg": "80", "--omega-rad-s": "5"}
Options = dict[str, str]
MOST_REFUSALS = 5  # a combination may be wrong in several ways, and is told one at a time


def drawn(rng: random.Random) -> Options:
    picked = rng.sample(sorted(CHOICES), rng.randint(1, 6))
    robot = {"--robot": rng.choice(["2005", "paper"])}
    return robot | GAIT | {"--duration-s": "0.05"} | {o: rng.choice(CHOICES[o]) for o in picked}


def refusal(options: Options) -> str:
    """Return what the command says against these options; empty if it runs."""
    words = [word for pair in options.items() for word in pair if word]
    done = serpenoid("simulate --json", *words)
    return done.stderr.strip().splitlines()[-1] if done.returncode else ""


def ways_out(options: Options, said: str) -> list[Options]:
    """Return the options as the refusal says that they could be."""
    if found := re.search(r"(--[\w-]+) has no effect", said):
        given = re.search(r"give (--[\w-]+) (\w+) too", said)
        ways = [options | {given[1]: given[2]}] if given else []
        return [*ways, without(options, found[1])]
    if "choose one drive" in said:
        return [without(options, "--servo-fields"), without(options, "--torque-nm")]
    if found := re.search(r"(--[\w-]+) \S+ was given; .* leave it open", said):
        return [without(options, found[1])]
    _, told, advice = said.rpartition("take ")
    if not told:
        return []
    changes = [
        {f"--{name}": value}
        for name, value in re.findall(r"(method|formulation|start) '(\w+)'", advice)
    ]
    changes += [{o: v} for o, v in re.findall(r"(--[a-z-]+) (\d[\d.e+-]*)", advice)]
    ways = [options | change for change in changes]
    return [without(w, *SPRINGS) if w.get("--formulation") == "explicit" else w for w in ways]


SPRINGS = ("--stiffness-n-m", "--damping-n-s-m", "--gap")  # who leaves the springs leaves these


def without(options: Options, *left_out: str) -> Options:
    return {o: v for o, v in options.items() if o not in left_out}


def follow(options: Options, depth: int = 0) -> list[str]:
    """Return the refusals that are met on the way that they point out, worst branch first."""
    said = refusal(options)
    if not said:
        return []
    ways = ways_out(options, said)
    if not ways or depth == MOST_REFUSALS:
        return [f"{options}: {said}"]
    if depth:  # every way out of the first refusal is gone, of later ones the first
        ways = ways[:1]
    for way in ways:
        if way == options:
            return [f"{options}: says what was given: {said}"]
        if lost := follow(way, depth + 1):
            return [f"{options}: {said}", *lost]
    return []


@pytest.mark.parametrize("seed", range(2))
def test_advice_leads_to_a_run(seed) -> None:
    rng = random.Random(seed)
    refused = 0
    for _ in range(60):
        options = drawn(rng)
        refused += bool(refusal(options))
        assert not (lost := follow(options)), "\n".join(lost)
    assert refused > 15
