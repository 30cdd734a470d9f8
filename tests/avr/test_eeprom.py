"""Settings in the EEPROM of the chip: they outlive power cuts, and nothing is written in motion.

Every byte of a save is cut in firmware/test_settings; here a few are, as the chip writes them.
"""

import pytest
from avr.board import TORN, Board
from avr.dialogue import JOINTS, Dialogue, fields

pytestmark = pytest.mark.avr

OLD = {"angle_ramp": 61.5, "rate_ramp": 3.25, "pose_speed": 50.75, "silence": 7.25}
NEW = {"angle_ramp": 222.125, "rate_ramp": 77.5, "pose_speed": 111.875, "silence": 33.5}
OLD_CENTRE_US, NEW_CENTRE_US = 1420, 1580  # of every servo
SAVE_S = 3.0  # two copies of well under 100 bytes at 3.4 ms


def change(talk: Dialogue, settings: dict[str, float], centre_us: int) -> None:
    for name, value in settings.items():
        assert talk.ask(f"set {name} {value}").startswith("ok:")
    for joint in range(1, JOINTS + 1):
        assert talk.ask(f"trim {joint} centre {centre_us}").startswith("ok:")


def listed(talk: Dialogue) -> dict[str, float]:
    """Return all settings and the servos' common centre as the board lists them."""
    rows, verdict = talk.ask_data("set")
    assert verdict.startswith("ok:")
    found = {row.split()[1]: float(fields(row)["value"]) for row in rows if row.startswith("set:")}
    trims, verdict = talk.ask_data("trim")
    assert verdict.startswith("ok:")
    centres = {float(fields(row)["centre"]) for row in trims if row.startswith("trim:")}
    assert len(centres) == 1, f"mixed centres {centres}"
    return {**found, "centre": centres.pop()}


def opened(board) -> Dialogue:
    talk = Dialogue(board)
    talk.hello()
    return talk


@pytest.fixture(scope="module")
def old_eeprom(firmware_elf) -> bytes:
    """An EEPROM with the old settings saved twice, so that both copies are whole."""
    with Board(firmware_elf("uno")) as board:
        talk = opened(board)
        for _ in range(2):
            change(talk, OLD, OLD_CENTRE_US)
            assert talk.ask("save", SAVE_S).startswith("ok:")
        assert board.counts.eeprom_ignored == 0
        return board.eeprom


def test_saved_settings_survive_power_loss(start, old_eeprom):
    talk = opened(start(eeprom=old_eeprom))
    assert fields(talk.greeting)["settings"] == "ok"
    assert listed(talk).items() >= (OLD | {"centre": OLD_CENTRE_US}).items()


def save_cut(start, eeprom: bytes, nth: int, torn: str):
    """Save the new settings with the power cut at the n-th byte; return the board."""
    talk = opened(start(eeprom=eeprom))
    change(talk, NEW, NEW_CENTRE_US)
    talk.send("save")
    talk.board.run(0.002)  # the line is on the wire; not yet a byte written
    talk.board.cut_power(nth, torn)
    talk.board.run(SAVE_S)
    return talk.board


@pytest.mark.parametrize("torn", TORN)
@pytest.mark.parametrize("nth", [1, 12, 24, 33])
def test_a_power_cut_in_a_save_of_36_bytes_leaves_the_old_settings(start, old_eeprom, nth, torn):
    board = save_cut(start, old_eeprom, nth, torn)
    assert board.state == "power cut"
    after = opened(start(eeprom=board.eeprom))
    assert listed(after).items() >= (OLD | {"centre": OLD_CENTRE_US}).items()
    assert fields(after.greeting)["settings"] in ("ok", "older")


@pytest.mark.parametrize("torn", TORN)
def test_a_power_cut_at_boot_costs_neither_its_number_nor_a_setting(start, old_eeprom, torn):
    boot = int(fields(opened(start(eeprom=old_eeprom)).greeting)["boot"])
    board = start(eeprom=old_eeprom)
    board.cut_power(1, torn)
    assert board.run(0.5) == "power cut"
    after = fields(opened(start(eeprom=board.eeprom)).greeting)
    assert int(after["boot"]) in (boot, boot + 1)
    assert after["settings"] == "ok"


def test_nothing_is_written_in_motion(start):
    board = start()
    talk = opened(board)
    assert talk.ask("gait 20 60 4").startswith("ok:")
    writes = board.counts.eeprom_writes
    for command, error in (("save", "motion"), ("load", "attached"), ("defaults", "attached")):
        assert f" {error} " in talk.ask(command), command
    talk.keep_alive(1.0)
    assert board.counts.eeprom_writes == writes
