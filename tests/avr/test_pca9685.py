"""Servos at a PCA9685: its registers are what telemetry says, and it is off whenever it must be."""

import numpy as np
import pytest
from avr.dialogue import Dialogue, fields, telemetry

pytestmark = pytest.mark.avr

MODE1, FIRST_CHANNEL, PRESCALE = 0x00, 0x06, 0xFE
NO_PULSES = 0xD0  # RESTART, EXTCLK (no such clock is connected), SLEEP
FULL_OFF = 0x10
OSCILLATOR_MHZ = 25.0


def outputs_us(board, joints: int = 5, oscillator_mhz: float = OSCILLATOR_MHZ) -> np.ndarray:
    """Return the pulse of each channel, 0 if there is none, by the data sheet's own formula."""
    registers = board.pca9685
    tick_us = (registers[PRESCALE] + 1) / oscillator_mhz
    widths = []
    for at in range(FIRST_CHANNEL, FIRST_CHANNEL + 4 * joints, 4):
        on, off = (int.from_bytes(registers[k : k + 2], "little") for k in (at, at + 2))
        is_off = registers[at + 3] & FULL_OFF or registers[MODE1] & NO_PULSES
        widths.append(0.0 if is_off else (off - on) % 4096 * tick_us)
    return np.array(widths)


def enabled(board) -> bool:
    """Tell whether the pin of /OE is low."""
    return len(board.edges) > 0 and board.edges["level"][-1] == 0


def check_straight(talk: Dialogue) -> None:
    """Find the driver again: it makes the pulses of a straight robot."""
    talk.obey("pose straight")
    talk.board.run(2.5)
    assert enabled(talk.board)
    assert np.all(np.abs(outputs_us(talk.board) - 1500) < 3)


@pytest.mark.parametrize(
    ("name", "joints"), [("uno", 5), pytest.param("mega", 12, marks=pytest.mark.slow)]
)
def test_the_registers_are_the_pulses_of_telemetry(start, name, joints):
    board = start(name, joints=joints, output="pca9685")
    talk = Dialogue(board).obey("hello")
    assert fields(talk.greeting)["frame_us"] == "20000"
    assert board.pca9685[PRESCALE] == 121  # 25 MHz / (4096 * 50 Hz) - 1, rounded
    assert not np.any(outputs_us(board, joints))
    assert not enabled(board)
    talk.obey("set silence off", "gait 45 80 8")
    board.run(2.5)
    board.run_until("t:", 0.05)
    bursts, first = board.pca9685_bursts, len(board.lines) - 1
    tick_us = 122 / OSCILLATOR_MHZ
    for _ in range(60):
        board.run_until("t:", 0.05)
        seen = telemetry(board.lines[-1:])
        assert np.all(np.abs(outputs_us(board, joints) - seen.pulse_us[-1]) <= tick_us / 2 + 1e-6)
        assert enabled(board)
    seen = telemetry(board.lines[first:])
    assert set(np.diff(seen.frame)) == {1}
    assert board.pca9685_bursts - bursts == seen.frame[-1] - seen.frame[0]  # one for all joints
    assert board.counts.twi_misused == 0
    assert talk.counters()["overruns"] == 0
    talk.obey("idle")
    board.run(0.05)
    assert not np.any(outputs_us(board, joints))
    assert not enabled(board)


@pytest.mark.slow
def test_the_rate_and_the_oscillator_are_settings_and_answers_cost_no_line(start):
    board = start("uno", output="pca9685")
    talk = Dialogue(board).obey("hello")
    assert "low=5 high=20" in talk.ask("set frame_ms 4.9")
    talk.obey("set frame_ms 5", "set oscillator 26.5", "save")
    board.reset()
    talk = Dialogue(board).obey("hello")
    assert fields(talk.greeting)["frame_us"] == "5000"
    assert board.pca9685[PRESCALE] == round(26.5 * 5000 / 4096) - 1
    talk.obey("set silence off", "pose 10 -20 30 -40 50")
    board.run(3.0)
    seen = telemetry(board.lines[-8:])
    assert set(np.diff(seen.frame)) == {4}  # a line and an answer take longer than three frames
    tick_us = (board.pca9685[PRESCALE] + 1) / 26.5
    widths = outputs_us(board, oscillator_mhz=26.5)
    assert np.all(np.abs(widths - seen.pulse_us[-1]) <= tick_us / 2 + 1e-6)
    talk.obey("gait 30 80 6")
    board.run(3.0)
    before = talk.counters()
    talk.keep_alive(2.0, every_s=0.1)
    counters = talk.counters()
    assert counters["overruns"] == 0
    assert counters["dropped"] - before["dropped"] <= 2
    assert counters["late_us"] <= 2000


@pytest.mark.parametrize("fault", ["silent", "data low"])
def test_without_a_driver_nothing_moves(start, fault):
    board = start("uno", output="pca9685")
    board.fault_pca9685(fault)
    talk = Dialogue(board).obey("hello")
    assert " output " in talk.ask("gait 30 80 5")
    assert not enabled(board)
    board.fault_pca9685("well")
    check_straight(talk)


@pytest.mark.parametrize("fault", ["silent", "power lost for a moment", "data low"])
def test_a_lost_driver_ends_all_pulses_and_is_found_again(start, fault):
    board = start("uno", output="pca9685")
    talk = Dialogue(board).obey("hello", "set silence off", "gait 45 80 8")
    board.run(2.5)
    assert np.all(outputs_us(board) > 500)
    before, seen = talk.counters(), len(board.lines)
    board.fault_pca9685("silent" if "power" in fault else fault)
    board.fault_pca9685("well" if "power" in fault else fault)
    board.run(0.045)  # two frames and a line
    assert not enabled(board)
    board.run_until("t:", 0.05)
    assert " p=0,0,0,0,0 " in board.lines[-1].text
    assert any("state: idle why=output" in line.text for line in board.lines[seen:])
    assert talk.counters()["overruns"] == before["overruns"], "a wedged bus costs no frame"
    board.fault_pca9685("well")
    check_straight(talk)


def test_a_hang_ends_all_pulses(start):
    board = start("uno", output="pca9685")
    Dialogue(board).obey("hello", "pose straight")
    board.run(1.0)
    assert enabled(board)
    board.hang()
    assert "reset=watchdog" in board.run_until("hello:", 3.0).text
    board.run(0.1)
    assert not enabled(board)
    assert not np.any(outputs_us(board))
