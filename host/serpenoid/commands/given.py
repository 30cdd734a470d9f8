"""The robot and the friction of a command: `--robot`, and the numbers that `--set` changes."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import serpenoid as sn

from ..base.errors import BadInput
from ..show.screen import say
from .declare import Given, refuse_unused
from .options import FRICTION, IDEAL, ROBOT, servo_kind


@dataclass(frozen=True)
class Snake:
    """A robot on its ground.

    fit: whose friction it is; None of a preset, of a scene, and where a number of it was changed.
    session: that it came from, if it did. notes: of its fit, for JSON.
    """

    robot: sn.Robot
    ground: sn.Ground
    fit: sn.FrictionFit | None = None
    session: sn.Session | None = None
    notes: Given = field(default_factory=dict)


def preset(name: str) -> Snake:
    """Return the robot of the paper's experiment, "2005", or of its theory, "paper"."""
    if name == "paper":
        return Snake(sn.Robot(6, 1.0, 0.12), sn.Ground(0.1, 10.0))
    robot = sn.Robot(6, 0.0756, 0.076)
    return Snake(robot, sn.Ground.whole_body(6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27))


def named_snake(name: str) -> Snake:
    """Return the robot and ground of a preset, a session's folder, a fit.json or a scene.

    What forbids to trust a fit is told. Raises BadInput for a name that is none of these.
    """
    if name in ("2005", "paper"):
        return preset(name)
    path = Path(name)
    if path.suffix == ".toml" and path.is_file():
        scene = sn.load_scene(path)
        return Snake(scene.robot, scene.ground)
    session = sn.load_session(path) if path.is_dir() else None
    if session is not None:
        fit = session_fit(session)
    elif path.suffix == ".json":
        fit = tell_alarms(sn.load_fit(path))
    else:
        raise BadInput(
            f"--robot is {name!r}; it must be 2005, paper, a session's folder, a fit.json or a "
            "scene (.toml)"
        )
    return Snake(fit.robot, fit.ground, fit, session, alarms_of(fit))


def make_snake(name: str | None, settings: Given, base: Snake | None = None) -> Snake:
    """Return the robot and ground of --robot, else `base`, else 2005, with the numbers of --set.

    Mass and friction are those of the whole robot. Where `links` alone is set, every link keeps
    its own.
    """
    if name is not None or base is None:
        base = named_snake(name or "2005")
    body = {one.name: settings[one.name] for one in ROBOT if one.name in settings}
    friction = {one.name: settings[one.name] for one in FRICTION if one.name in settings}
    if not body and not friction:
        return base
    old, ground = base.robot, base.ground
    links = body.pop("links", old.links)
    rod = old == sn.Robot(old.links, old.link_mass_kg, old.link_length_m)  # a rod stays one
    kept = {
        "mass_kg": links * old.link_mass_kg,
        "link_length_m": old.link_length_m,
        "link_inertia_kg_m2": None if rod else old.link_inertia_kg_m2,
    }
    robot = sn.Robot.whole_body(links, **(kept | body))
    if friction:
        whole = asdict(ground.scaled(*4 * [links]))
        ground = sn.Ground.whole_body(links, **(whole | friction))
    return replace(base, robot=robot, ground=ground, fit=None)


def session_fit(session: sn.Session) -> sn.FrictionFit:
    """Return a session's fit.json if it is that of its readings, else fit them now."""
    from ..friction.file import NAME, rests_on

    folder = session.folder
    if folder and (folder / NAME).exists():
        try:
            kept = sn.load_fit(folder)
            if rests_on(kept, session):
                return tell_alarms(kept)
        except sn.BadInput as error:  # an older version's, or edited: the readings are there
            say(f"serpenoid: warning: {error}; fitted anew", err=True)
    return tell_alarms(sn.fit_friction(session))


def take_servo(name: str, settings: Given, snake: Snake | None = None) -> sn.ServoKind | None:
    """Return the servos of a name; None for joints that are ideal.

    snake: of a session, which has their voltage and the frames of its board.
    """
    from ..session.crawls import driving

    if name.lower() == IDEAL:
        refuse_unused(settings, "joints are ideal; give --servo NAME", "volts", "frame_ms")
        return None
    kind = servo_kind(name, settings)
    return driving(snake.session.setup, kind) if snake and snake.session else kind


def tell_alarms(fit: sn.FrictionFit) -> sn.FrictionFit:
    """Warn of what forbids to trust a fit, note what was not measured; return the fit."""
    notes = alarms_of(fit)
    for alarm in notes.get("fit_alarms", ()):
        say(f"serpenoid: warning: {alarm}", err=True)
    for note in notes.get("fit_notes", ()):
        say(f"note: {note}", err=True)
    return fit


def alarms_of(fit: sn.FrictionFit) -> Given:
    """Return what forbids to trust a fit and what was not measured, as JSON answers have it."""
    old = [note for note in fit.notes if "is older than the readings" in note]
    notes = {"fit_alarms": [*fit.alarms, *old], "fit_notes": fit.unmeasured}
    return {key: words for key, words in notes.items() if words}
