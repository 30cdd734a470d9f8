"""The robot that a rod stands for: its masses sit at the nodes, between the links."""

from __future__ import annotations

from dataclasses import replace

from ...model.robot import Robot

RADIUS_OF_LENGTH = 1 / 6  # of the rod's section, by the length of a link


def as_rod_sees_it(robot: Robot) -> Robot:
    """Return the robot with the inertia that a rod's masses at its nodes give to a link."""
    m, length = robot.link_mass_kg, robot.link_length_m
    own = m * (RADIUS_OF_LENGTH * length) ** 2 / 4
    return replace(robot, link_inertia_kg_m2=m * length**2 / 4 + own)
