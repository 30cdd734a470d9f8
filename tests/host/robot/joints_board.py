"""Virtual boards of another number of joints, behind every port that is opened."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from serpenoid.robot.wire.virtual import VirtualLink


@pytest.fixture(params=[6, 8])
def joints(request: pytest.FixtureRequest) -> int:
    """Return the number of joints, six and then eight."""
    return request.param


@pytest.fixture
def joints_link(joints: int, monkeypatch: pytest.MonkeyPatch) -> Callable[..., VirtualLink]:
    """Put a board of so many joints behind every port a Robot opens; return what opens one."""

    def open_link(_port: str | None = None) -> VirtualLink:
        return VirtualLink(fast=True, joints=joints)

    monkeypatch.setattr("serpenoid.robot.robot.open_link", open_link)
    return open_link
