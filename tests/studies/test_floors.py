"""The floors of periodic states count what their words say."""

from __future__ import annotations

import pytest
from floors import dry_products, line, viscous_products


def test_the_floors_count_what_they_say() -> None:
    assert viscous_products() == pytest.approx(14_000, rel=0.03)
    assert viscous_products() - viscous_products(powers=False) == pytest.approx(3500, rel=0.02)
    assert dry_products() == pytest.approx(19 * 7000, rel=0.1)


def test_a_line_has_the_ratio() -> None:
    assert line("grid", 0.45, 0.09, "a step") == "grid: 0.45 s, 5.0 times its floor 0.09 s: a step"
