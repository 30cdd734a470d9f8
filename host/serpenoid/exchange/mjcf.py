"""A robot and its ground in MuJoCo's language (MJCF), with the friction that it can say."""

from __future__ import annotations

import warnings
from xml.etree import ElementTree as ET

from ..model.checks import check_number, check_whole
from ..model.core_model import check_parts
from ..model.errors import BadInput
from ..model.ground import Ground
from ..model.robot import Robot

MOST_LINKS = 300  # MJCF nests a body a link, and XML libraries recurse as deep


def to_mjcf(robot: Robot, ground: Ground, *, timestep_s: float = 1e-3) -> str:
    """Return a robot as an MJCF document: planar, hinged at the joints, a motor on each.

    Link 1, the tail, moves on two slides and a hinge, `x`, `y`, `turn`, from the origin along x.
    Joint i is the hinge `joint<i>` with the motor `torque<i>`, N m on link i from link i+1 as in
    serpenoid (minus MuJoCo's sign). Viscous friction is exact: two actuators without a control at
    each link's centre. MuJoCo cannot state dry friction that differs along and across: it is left
    out with a warning.

    Parameters
    ----------
    robot, ground
        What crawls, and on what.
    timestep_s
        MuJoCo's step, s.

    Returns
    -------
    str
        The document.

    Raises
    ------
    BadInput
        For ratchet wheels and arguments out of range.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=0.0756, link_length_m=0.076)
    >>> text = sn.to_mjcf(robot, sn.Ground(ct=0.01, cn=0.2))
    >>> text.count("<hinge") + text.count('type="hinge"') >= 5
    True
    """
    check_parts(robot, ground)
    timestep_s = check_number("timestep_s", timestep_s, 0.0, open_low=True)
    check_whole("links", robot.links, 2, MOST_LINKS)
    if ground.ratchet:
        raise BadInput(
            f"ct is {ground.ct!r} and ft0 {ground.ft0!r}: MuJoCo has no friction that differs "
            "forwards and backwards; give a Ground with single values"
        )
    if ground.dry:
        warnings.warn(
            "MuJoCo has no dry friction that differs along and across: ft0 "
            f"{ground.ft0_forward:g} N and fn0 {ground.fn0:g} N are left out",
            stacklevel=2,
        )
    root = ET.Element("mujoco", model="serpenoid")
    step = {"timestep": f"{timestep_s!r}", "gravity": "0 0 0", "integrator": "RK4"}
    ET.SubElement(ET.SubElement(root, "option", step), "flag", contact="disable")
    parent, actuators = ET.SubElement(root, "worldbody"), ET.Element("actuator")
    for link in range(1, robot.links + 1):
        parent = _link(parent, robot, link)
        _drag(actuators, f"wheels{link}", ground)
    for joint in range(1, robot.links):
        ET.SubElement(actuators, "motor", name=f"torque{joint}", joint=f"joint{joint}", gear="-1")
    root.append(actuators)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _link(parent: ET.Element, robot: Robot, link: int) -> ET.Element:
    """Add one link at the end of the one before it."""
    length, inertia = robot.link_length_m, robot.inertia_kg_m2
    place = f"{length!r} 0 0" if link > 1 else "0 0 0"
    body = ET.SubElement(parent, "body", name=f"link{link}", pos=place)
    if link == 1:
        ET.SubElement(body, "joint", name="x", type="slide", axis="1 0 0")
        ET.SubElement(body, "joint", name="y", type="slide", axis="0 1 0")
        ET.SubElement(body, "joint", name="turn", type="hinge", axis="0 0 1")
    else:
        ET.SubElement(
            body,
            "joint",
            name=f"joint{link - 1}",
            type="hinge",
            axis="0 0 1",
            pos=f"{-length / 2!r} 0 0",
        )
    ET.SubElement(
        body,
        "inertial",
        pos="0 0 0",
        mass=f"{robot.link_mass_kg!r}",
        diaginertia=f"{inertia!r} {inertia!r} {inertia!r}",
    )
    ET.SubElement(
        body,
        "geom",
        type="capsule",
        size=f"{length / 10!r}",
        fromto=f"{-0.4 * length!r} 0 0 {0.4 * length!r} 0 0",
    )
    ET.SubElement(body, "site", name=f"wheels{link}")
    return body


def _drag(actuators: ET.Element, site: str, ground: Ground) -> None:
    for name, axis, c in (("along", "1 0 0", ground.ct_forward), ("across", "0 1 0", ground.cn)):
        ET.SubElement(
            actuators,
            "general",
            name=f"{site}_{name}",
            site=site,
            gear=f"{axis} 0 0 0",
            gainprm="0",
            biastype="affine",
            biasprm=f"0 0 {-c!r}",
        )
