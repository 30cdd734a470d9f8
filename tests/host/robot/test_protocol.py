"""The host's reading of the wire, held to PROTOCOL.md's examples and the firmware's table."""

import contextlib
import math

import pytest
from avr.dialogue import sealed
from hypothesis import given, seed
from hypothesis import strategies as st
from serpenoid.base.errors import DamagedLine
from serpenoid.robot.wire import protocol

FRAME = (
    "t:1234 j1:10.00 j2:-3.25 j3:0.00 j4:7.50 j5:-10.00 board_us=24680124 ph=123.456"
    " p=1600,1467,1500,1575,1400 exec_us=412 late_us=8 clipped=1 st=gait"
)
BODIES = [
    FRAME,
    "hello: serpenoid fw=0.3.0 protocol=5 board=uno joints=5 frame_us=20000 boot=37 reset=power"
    " settings=ok silence=2",
    "ok: #12",
    "err: #12 range alpha=95 low=0 high=90 - CAUSE; CURE",
]


def test_a_frame_in_si_and_the_sensor_of_a_builder():
    """All other words are held in tests/golden, by one dialogue of host and board."""
    frame = protocol.parse(sealed(f"{FRAME} sensor=-12"))
    assert (frame.frame, frame.board_us, frame.sensor) == (1234, 24680124, -12)
    assert frame.setpoint_rad[1] == math.radians(-3.25)
    assert frame.phase_rad == math.radians(123.456)
    assert protocol.parse(sealed(FRAME)).sensor is None


@pytest.mark.parametrize("body", BODIES)
def test_every_cut_and_every_flipped_bit_is_noticed(body):
    line = sealed(body)[:-1]
    for length in range(len(line)):
        with pytest.raises(DamagedLine):
            protocol.parse(line[:length])
    for bit in range(8 * len(line)):
        damaged = bytearray(line)
        damaged[bit // 8] ^= 1 << bit % 8
        with pytest.raises(DamagedLine):
            protocol.parse(bytes(damaged))


@seed(5)
@given(st.text(st.characters(max_codepoint=126), max_size=40))
def test_nonsense_sealed_or_not_is_refused_as_damage_or_understood(text):
    for word in ("t:", "ok:", "err:", "hello:", "trim:", ""):
        for line in (sealed(word + text), text.encode()):
            with contextlib.suppress(DamagedLine):
                protocol.parse(line)


@pytest.mark.parametrize(
    ("field", "wrong"),
    [
        ("t:1234", f"t:{2**32}"),
        ("board_us=24680124", f"board_us={2**32}"),
        ("exec_us=412", f"exec_us={2**32}"),
        ("late_us=8", f"late_us={2**32}"),
        ("clipped=1", "clipped=6"),
        ("j2:", "j3:"),
        (",1400", ""),
        ("joints=5", "joints=13"),
        ("silence=2", "silence=" + "9" * 400),
        ("j2:-3.25", f"j2:{'9' * 400}.00"),
        *((",1575", f",{pulse}") for pulse in ("157500", "1_5")),
        ("ph=123.456", "ph=1234.567"),
        *(("frame_us=20000", f"frame_us={us}") for us in (2999, 32501)),
    ],
)
def test_values_that_no_board_can_have_are_damage_though_the_crc_is_right(field, wrong):
    body = next(b for b in BODIES if field in b)
    protocol.parse(sealed(body))
    with pytest.raises(DamagedLine):
        protocol.parse(sealed(body.replace(field, wrong)))


@pytest.mark.parametrize("joints", [2, 8, 12])
def test_the_longest_pose_fits_a_line(joints):
    pose = "pose" + " -114.000000" * joints
    assert len(protocol.seal(pose, 65535, joints)) <= protocol.line_limit(joints) + 1
