"""Types of the compiled core, generated: `.ci/stubs host/serpenoid/_core`."""

from typing import Annotated

import numpy
from numpy.typing import NDArray

FRAME_S: float

JOINTS: int

VERSION: str

PROTOCOL: int

ERRORS: list

SETTINGS: dict

TRIM: dict

GAIT: dict

class Board:
    """
    The firmware's controller on a simulated clock, wire and servos.

    It must be booted before it is run; the wire has its true pace. joints:
    2 to 12.
    """

    def __init__(self, start_us: int = 0, joints: int = 5) -> None: ...
    def boot(self, reset: str = "power", first_frame: int = 0) -> None:
        """Start anew with the same EEPROM; what was on the wire is lost."""

    def run(self, seconds: float) -> None:
        """Let so much of the board's time pass."""

    def stall(self, seconds: float) -> None:
        """Let time pass without the programme running."""

    def write(self, data: bytes) -> None:
        """Put bytes on the wire to the board."""

    def read(self) -> bytes:
        """Return all bytes that have arrived from the board since the last call."""

    @property
    def eeprom(self) -> bytes:
        """All 1024 bytes; change them while it is not running."""

    @eeprom.setter
    def eeprom(self, arg: bytes, /) -> None: ...
    @property
    def time_s(self) -> float: ...
    @property
    def state(self) -> str: ...
    @property
    def frame(self) -> int: ...
    @property
    def boot_id(self) -> int: ...
    @property
    def session(self) -> bool: ...
    @property
    def counters(self) -> dict:
        """Counts since boot, by the names of PROTOCOL.md."""

    @property
    def setpoints_rad(self) -> list[float]:
        """The joints' setpoints, tail first."""

    @property
    def pulses_us(self) -> list[int]:
        """The pulse width each servo gets, 0 while detached."""

def gait_setpoints_rad(
    alpha_rad: float,
    beta_rad: float,
    omega_rad_s: float,
    *,
    offset_rad: float = 0.0,
    first_frame: int = 0,
    frames: int = 1,
    joints: int = 5,
) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
    """
    Return the settled gait's setpoints, (frames, joints), radians, one row per 20 ms.

    The phase is 0 at frame 0. Fixed point: within 0.012 degrees of Eq. 57. Raises
    ValueError for alpha or offset beyond 90 degrees, beta beyond 180, omega beyond 50.
    """

def crc16(data: bytes) -> int:
    """Return CRC-16/IBM-3740 of some bytes, as on the wire."""
