"""Servos at a PCA9685: its registers are what telemetry says, and it is off whenever it must be."""

import numpy as np
import pytest
from avr.dialogue import Dialogue, fields, telemetry

pytestmark = pytest.mark.avr

MODE1, FIRST_CHANNEL, PRESCALE = 0x00, 0x06, 0xFE
NO_PULSES = 0xD0  # RESTART, EXTCLK (no such clock is connected), SLEEP
FULL_OFF = 0x10
OSCILLATOR_MHZ = 25.0
TWSR, TWCR, TWINT = 0xB9, 0xBC, 0x80  # data memory of both chips
ANSWERS = 0x40  # the chip has been asked to send


def opened(board) -> Dialogue:
    talk = Dialogue(board)
    talk.hello()
    return talk


def obeyed(talk: Dialogue, *commands: str) -> None:
    for command in commands:
        verdict = talk.ask(command, 5.0)
        assert verdict.startswith("ok:"), (command, verdict)


def in_gait(start, **options) -> Dialogue:
    talk = opened(start(output="pca9685", **options))
    obeyed(talk, "set silence off", "gait 45 80 8")
    talk.board.run(2.5)
    assert enabled(talk.board)
    assert np.all(outputs_us(talk.board) > 500)
    return talk


def outputs_us(board, joints: int = 5, oscillator_mhz: float = OSCILLATOR_MHZ) -> np.ndarray:
    """Return the pulse of each channel, 0 if there is none, by the data sheet's own formula."""
    registers = board.pca9685
    tick_us = (registers[PRESCALE] + 1) / oscillator_mhz
    widths = []
    for joint in range(joints):
        at = FIRST_CHANNEL + 4 * joint
        on, off = (int.from_bytes(registers[k : k + 2], "little") for k in (at, at + 2))
        is_off = registers[at + 3] & FULL_OFF or registers[MODE1] & NO_PULSES
        widths.append(0.0 if is_off else (off - on) % 4096 * tick_us)
    return np.array(widths)


def enabled(board) -> bool:
    """Tell whether the pin of /OE is low."""
    edges = board.edges
    return len(edges) > 0 and edges["level"][-1] == 0


def limp(board) -> bool:
    """Tell whether no servo can get a pulse."""
    return not enabled(board) and board.lines[-1].text.count("p=0,0,0,0,0") == 1


@pytest.mark.parametrize(
    ("name", "joints"), [("uno", 5), pytest.param("mega", 12, marks=pytest.mark.slow)]
)
def test_the_registers_are_the_pulses_of_telemetry(start, name, joints):
    board = start(name, joints=joints, output="pca9685")
    talk = opened(board)
    assert fields(talk.greeting)["frame_us"] == "20000"
    assert board.pca9685[PRESCALE] == 121  # 25 MHz / (4096 * 50 Hz) - 1, rounded
    assert not np.any(outputs_us(board, joints))
    assert not enabled(board)
    obeyed(talk, "set silence off", "gait 45 80 8")
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
    obeyed(talk, "idle")
    board.run(0.05)
    assert not np.any(outputs_us(board, joints))
    assert not enabled(board)


@pytest.mark.slow
def test_the_rate_and_the_oscillator_are_settings(start):
    board = start("uno", output="pca9685")
    talk = opened(board)
    assert "low=5 high=20" in talk.ask("set frame_ms 4.9")
    obeyed(talk, "set frame_ms 5", "set oscillator 26.5", "save")
    board.reset()
    talk = opened(board)
    assert fields(talk.greeting)["frame_us"] == "5000"
    assert board.pca9685[PRESCALE] == round(26.5 * 5000 / 4096) - 1
    obeyed(talk, "set silence off", "pose 10 -20 30 -40 50")
    board.run(3.0)
    seen = telemetry(board.lines[-8:])
    assert set(np.diff(seen.frame)) == {4}  # a line and an answer take longer than three frames
    tick_us = (board.pca9685[PRESCALE] + 1) / 26.5
    widths = outputs_us(board, oscillator_mhz=26.5)
    assert np.all(np.abs(widths - seen.pulse_us[-1]) <= tick_us / 2 + 1e-6)
    obeyed(talk, "gait 30 80 6")
    board.run(3.0)
    before = talk.counters()
    talk.keep_alive(2.0, every_s=0.1)  # a line every fourth frame leaves room for the answers
    counters = talk.counters()
    assert counters["overruns"] == 0
    assert counters["dropped"] - before["dropped"] <= 2
    assert counters["late_us"] <= 2000


@pytest.mark.parametrize(
    ("name", "joints", "frame_ms", "every"),
    [
        ("uno", 5, 12.2, 2),  # just above the place where a line alone fits each frame
        pytest.param("uno", 5, 14.0, 1, marks=pytest.mark.slow),
        pytest.param("mega", 8, 15.5, 2, marks=pytest.mark.slow),
        pytest.param("mega", 8, 20.0, 1, marks=pytest.mark.slow),
    ],
)
def test_answers_cost_no_telemetry_line(start, name, joints, frame_ms, every):
    board = start(name, joints=joints, output="pca9685")
    obeyed(opened(board), f"set frame_ms {frame_ms}", "save")
    board.reset()
    talk = opened(board)
    obeyed(talk, "set silence off", "gait 60 80 8")
    board.run(0.2 + 0.1 * joints)  # until all are attached
    seen = len(board.lines)
    for _ in range(10):
        obeyed(talk, "ping")
        board.run(0.0937)  # no fraction of a frame: pings meet every part of it
    assert set(np.diff(telemetry(board.lines[seen:]).frame)) == {every}


def test_a_restart_bit_that_stays_is_no_lost_driver(start):
    """Only a write of 1 clears it on some chips, though their outputs run."""
    board = in_gait(start).board
    board.fault_pca9685("restart")
    board.run(0.5)
    assert enabled(board)
    assert telemetry(board.lines[-3:]).state == ["gait"] * 3


@pytest.mark.parametrize("fault", ["silent", "data low", "clock low"])
def test_without_a_driver_nothing_moves(start, fault):
    board = start("uno", output="pca9685")
    board.fault_pca9685(fault)
    talk = opened(board)
    assert " output " in talk.ask("pose straight")
    assert " output " in talk.ask("gait 30 80 5")
    assert not enabled(board)
    board.fault_pca9685("well")
    obeyed(talk, "pose straight")
    board.run(1.0)
    assert np.all(np.abs(outputs_us(board) - 1500) < 3)


def test_a_chip_that_was_told_to_use_an_external_clock_is_reset(start):
    board = start("uno", output="pca9685")
    board.fault_pca9685("external clock")
    board.reset()
    obeyed(opened(board), "pose straight")
    board.run(1.0)
    assert np.all(np.abs(outputs_us(board) - 1500) < 3)


@pytest.mark.parametrize(
    "fault", ["silent", "power lost for a moment", "silent in a burst", "data low", "clock low"]
)
def test_a_lost_driver_ends_all_pulses_and_is_found_again(start, fault):
    talk = in_gait(start)
    board = talk.board
    before, seen = talk.counters(), len(board.lines)
    if fault == "silent in a burst":
        board.fault_pca9685("silent", after_bytes=9)
    elif fault == "power lost for a moment":
        board.fault_pca9685("silent")
        board.fault_pca9685("well")
    else:
        board.fault_pca9685(fault)
    board.run(0.045)  # two frames and a line
    assert not enabled(board)
    board.run_until("t:", 0.05)
    assert limp(board)
    assert any("state: idle why=output" in line.text for line in board.lines[seen:])
    after = talk.counters()
    assert after["overruns"] == before["overruns"], "a wedged bus costs no frame"
    board.fault_pca9685("well")
    obeyed(talk, "pose straight")
    board.run(2.5)
    assert enabled(board)
    assert np.all(np.abs(outputs_us(board) - 1500) < 3)


@pytest.mark.parametrize(
    ("name", "joints", "frame_ms"),
    [("uno", 5, 20.0), pytest.param("mega", 12, 9.2, marks=pytest.mark.slow)],
)
def test_one_lost_acknowledgement_costs_neither_pulse_nor_frame(start, name, joints, frame_ms):
    talk = opened(start(name, joints=joints, output="pca9685"))
    obeyed(talk, f"set frame_ms {frame_ms}", "save")
    talk.board.reset()
    talk = opened(talk.board)
    obeyed(talk, "set silence off", "gait 45 80 8")
    board = talk.board
    board.run(3.0)
    before, first, bursts = talk.counters(), len(board.lines), board.pca9685_bursts
    begun = telemetry(board.lines[-5:]).frame[-1]
    for nth in range(1, 6 + 4 * joints):  # the bytes of the burst, then three of a question
        board.fault_pca9685("no ack", after_bytes=nth)
        board.run(2e-3 * frame_ms)
    after = talk.counters()
    seen = telemetry(board.lines[first:])
    assert set(seen.state) == {"gait"}
    assert enabled(board)
    assert abs(board.pca9685_bursts - bursts - (seen.frame[-1] - begun)) <= 2
    assert after["overruns"] == before["overruns"] == 0
    assert after["late_us"] <= 2000


def test_a_hang_ends_all_pulses(start):
    board = in_gait(start).board
    board.hang()
    board.run_until("hello:", 3.0)
    assert any("reset=watchdog" in line.text for line in board.lines[-1:])
    board.run(0.1)
    assert not enabled(board)
    assert not np.any(outputs_us(board))


def test_a_reset_in_the_middle_of_an_answer_leaves_no_stuck_bus(start):
    """The chip goes on with its byte, and holds the data low, until it has had its clocks."""
    board = in_gait(start).board
    for _ in range(10_000):
        board.run(5e-6)
        ram = board.ram
        if ram[TWSR] & 0xF8 == ANSWERS and not ram[TWCR] & TWINT:
            break
    else:
        raise AssertionError("the chip was never asked")
    board.reset()
    talk = opened(board)
    assert not np.any(outputs_us(board))
    assert not enabled(board)
    obeyed(talk, "pose straight")
    board.run(1.0)
    assert np.all(np.abs(outputs_us(board) - 1500) < 3)
