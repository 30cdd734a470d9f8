"""People who type anything: no word at any prompt breaks the dialogue or loses a reading."""

import random
import re
import shutil
from dataclasses import replace

import pytest
from calibration.conversations import Typist
from serpenoid.commands.friction.calibrate_person import film_reader
from serpenoid.session.folder import numbered_rows, read_session
from serpenoid.session.journal import Journal
from serpenoid.taking.dialogue import Dialogue
from serpenoid.taking.new_session import create_session, default_setup, on_place

# Words of the prompts, nonsense, and numbers that fit somewhere.
TYPED = """\
undo|undo 1|undo 3|undo -1|undo ²|skip|pause|help|?|keep|u
| |nan|inf|-inf|1e400|0x10|1,2,3|1;2|--5|5 parsecs|%|é|\x1b[A|[b]|0|-0|y|n|k|2.3.4|+|,|.|½|\x00.csv
2|2.3|2,6|4 %|0.3|0.5 m/s|1.8 km/h|165|150|120|1.0|9.5|2.6 0.4|0.01 -2deg|0:0 2:0.045 4:0.13"""
WORDS, NONSENSE, FITTING = (line.split("|") for line in TYPED.split("\n"))
NONSENSE += ["~nobody", "9" * 400]


@pytest.fixture(scope="module", params=["treadmill", "floor"])
def begun(tmp_path_factory, request):
    setup = default_setup("made up")
    setup = replace(setup, plan=on_place(setup.plan, request.param))
    return create_session(tmp_path_factory.mktemp("fuzz") / "session", setup)


def talk(folder, lines):
    """Return what was heard; whatever was said to be kept is on the disk."""
    person = Typist(*lines)
    with Journal(folder) as journal:
        Dialogue(journal, person, film_reader(None)).run()
    kept = [int(n) for n in re.findall(r"kept as reading (\d+)", person.heard)]
    there = list(numbered_rows(folder / "readings.csv", []))
    assert set(kept) <= set(there)
    assert there == sorted(set(there))
    read_session(folder)
    return person.heard


@pytest.mark.parametrize("seed", range(4))
def test_anything_at_any_prompt(begun, tmp_path, seed):
    folder = shutil.copytree(begun, tmp_path / "session")
    made = random.Random(seed)
    lines = []
    for _ in range(150):
        pool = made.choices((WORDS, NONSENSE, FITTING), (1, 1, 4))[0]
        lines.append(made.choice(pool))
    heard = talk(folder, lines)
    assert "Everything read so far is kept" in heard or "is left to take" in heard
