"""The ladder of scenes, which is compiled anew for each count: its sources find their headers."""

from __future__ import annotations

import re
from pathlib import Path

from serpenoid.bench import scenes


def test_every_source_of_the_ladder_finds_its_headers() -> None:
    sources, include = scenes.parts()
    assert {"simulation.cpp", "radau.cpp", "ladder.cpp"} <= {source.name for source in sources}
    for source in sources:
        folders = [source.parent, *(Path(flag.removeprefix("-I")) for flag in include)]
        for header in re.findall(r'^#include "(.+)"', source.read_text(), re.MULTILINE):
            assert any((folder / header).exists() for folder in folders), (source, header)
