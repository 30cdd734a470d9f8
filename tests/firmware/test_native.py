"""The C++ tests of the firmware's libraries, run the way a user runs them: `pio test -e native`."""

from __future__ import annotations

import tarfile

import pytest
from avr.toolchain import pio

pytestmark = [pytest.mark.avr, pytest.mark.usefixtures("toolchain")]


def test_the_native_suites_pass() -> None:
    assert "succeeded" in pio("test", "-e", "native")


@pytest.mark.parametrize("library", ["gait", "protocol"])
def test_the_libraries_pack_for_others(library: str, tmp_path) -> None:
    pio("pkg", "pack", f"firmware/lib/{library}", "-o", str(tmp_path))
    (packed,) = tmp_path.iterdir()
    with tarfile.open(packed) as archive:
        names = archive.getnames()
    assert "library.json" in names
    assert any(name.endswith(".cpp") for name in names)
