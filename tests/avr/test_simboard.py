"""The simulated board itself, against what the data sheet says of the silicon."""

import subprocess

import numpy as np
import pytest
from avr.board import F_CPU_HZ, Board
from avr.toolchain import BUILD, HERE, MCUS, build_simulator

pytestmark = pytest.mark.avr

BYTE_CYCLES = 10 * F_CPU_HZ / 250_000


@pytest.fixture(params=["uno", "mega"])
def probe(request, firmware_elf):
    mcu = MCUS[request.param]
    build_simulator()
    elf = BUILD / f"probe-{mcu}.elf"
    flags = ["-Os", "-Wall", "-Wextra", "-Werror", f"-mmcu={mcu}", f"-DF_CPU={F_CPU_HZ}UL"]
    subprocess.run(["avr-gcc", *flags, "-o", str(elf), str(HERE / "probe.c")], check=True)
    with Board(elf, request.param, "B0") as board:
        board.run(0.01)
        yield board


def test_bytes_take_ten_bit_times_both_ways(probe):
    begin = len(probe.sent)
    probe.send(b"x" * 50)
    probe.run(0.01)
    echoed = np.array([cycle for cycle, _ in probe.sent[begin:]])
    assert len(echoed) == 50
    # simavr hands received bytes over in pairs: the first or last may be a byte early or late.
    assert echoed[-1] - echoed[0] == pytest.approx(49 * BYTE_CYCLES, abs=BYTE_CYCLES)
    assert probe.actual_baud == 250_000


def test_a_byte_waits_behind_the_one_that_is_sent(probe):
    """Two are taken at once: the first goes to the shift register. Then each waits for one."""
    begin = len(probe.sent)
    probe.send(b"b")
    probe.run(0.01)
    taken = np.diff([cycle for cycle, _ in probe.sent[begin:]])
    assert bytes(v for _, v in probe.sent[begin:]) == b"01234567b"
    assert taken[0] < 30
    assert taken[1:] == pytest.approx(BYTE_CYCLES, abs=30)


def test_a_deaf_program_loses_all_but_three_bytes(probe):
    probe.send(b"d")
    probe.run(0.001)
    probe.send(b"x" * 20)
    probe.run(0.01)
    assert probe.counts.overrun_bytes == 17
    assert bytes(v for _, v in probe.sent).endswith(b"dxxx")


def test_a_pulse_is_measured_to_the_cycle(probe):
    probe.send(b"pp")
    probe.run(0.01)
    np.testing.assert_allclose(probe.pulses(0).width_us, 1500, atol=0.5)


def test_eeprom_takes_its_time_and_keeps_its_content(probe):
    probe.send(b"e")
    before = probe.cycle
    probe.run(0.1)
    took_ms = (probe.sent[-1][0] - before) * 1e3 / F_CPU_HZ
    assert took_ms == pytest.approx(7 * 3.4, abs=0.3)  # the eighth write goes on behind it
    assert probe.eeprom[:9] == bytes(range(8)) + b"\xff"
    assert probe.counts.eeprom_writes == 8


@pytest.mark.parametrize(("torn", "byte"), [("old", 0xAA), ("erased", 0xFF), ("new", 2)])
def test_power_cut_tears_one_byte(probe, torn, byte):
    probe.eeprom = bytes([0xAA]) * len(probe.eeprom)
    probe.cut_power(3, torn)
    probe.send(b"e")
    assert probe.run(0.1) == "power cut"
    assert probe.eeprom[:4] == bytes([0, 1, byte, 0xAA])


def test_resets_tell_their_cause_and_keep_the_memory(probe):
    assert probe.lines[-1].text == "B11"
    probe.reset("external")
    probe.run(0.01)
    assert probe.lines[-1].text == "B22"
    probe.reset("brown-out")
    probe.run(0.01)
    assert probe.lines[-1].text == "B34"
    probe.send(b"w")
    probe.run(0.01)
    probe.hang()
    probe.run(0.1)
    assert probe.lines[-1].text == "w" + "B48"
    probe.send(b"x")
    probe.run(0.01)
    assert probe.sent[-1][1] == ord("x"), "the hang must end with the reset"
