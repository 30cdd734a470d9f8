"""Run firmware on a simulated AVR board in simulated time and read its pins, lines and memory."""

from __future__ import annotations

import ctypes
import subprocess
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from avr.toolchain import BOARDS, COMPILER, build_simulator

F_CPU_HZ = 16_000_000
RAM_END = {"atmega328p": 0x8FF, "atmega2560": 0x21FF}
PAINT = b"\xc5"  # what simboard fills the RAM with
# Digital pins 5 to 12, A0 to A3 (firmware/include/board.h) as port and bit, joint by joint.
SERVO_PINS = {"uno": "D5D6D7B0B1B2B3B4C0C1C2C3", "mega": "E3H3H4H5H6B4B5B6F0F1F2F3"}
ENABLE_PIN = {"uno": "D4", "mega": "G5"}
DATA_WIRE = {"uno": ("C", 4), "mega": ("D", 1)}
FAULTS = ("well", "silent", "data low")
CAUSES = ("power-on", "external", "brown-out")
EDGE = np.dtype([("cycle", "u8"), ("pin", "u4"), ("level", "u4")])
SENT = np.dtype([("cycle", "u8"), ("value", "u4"), ("unused", "u4")])


class Counts(ctypes.Structure):
    """What the simulated board has counted; the fields are explained in simboard.h."""

    _fields_ = [
        (name, ctypes.c_uint32)
        for name in (
            "resets",
            "overrun_bytes",
            "eeprom_ignored",
            "twi_misused",
        )
    ]


@dataclass(frozen=True)
class Line:
    """One line the board sent: the cycle at which its first byte went to the UART."""

    cycle: int
    text: str


@dataclass(frozen=True)
class Pulses:
    """The pulses of one pin: rising edges in cycles (N,) and widths in microseconds (N,)."""

    rise_cycle: np.ndarray
    width_us: np.ndarray


@cache
def _library() -> ctypes.CDLL:
    lib = ctypes.CDLL(str(build_simulator()))
    board, u8, u32, u64 = ctypes.c_void_p, ctypes.c_char_p, ctypes.c_uint32, ctypes.c_uint64
    size = ctypes.c_size_t
    for name, result, *arguments in (
        ("board_open", board, u8, u8, u32),
        ("board_close", None, board),
        ("board_run", ctypes.c_int, board, u64),
        ("board_cycle", u64, board),
        ("board_reset", None, board, ctypes.c_int),
        ("board_hang", None, board),
        ("board_counts", Counts, board),
        ("board_watch", ctypes.c_int, board, ctypes.c_char, ctypes.c_int),
        ("board_take_edges", size, board, ctypes.c_void_p, size),
        ("board_take_sent", size, board, ctypes.c_void_p, size),
        ("board_wire", None, board, u64, u32, u8, size),
        ("board_read_ram", None, board, ctypes.c_uint16, u8, size),
        ("board_eeprom_size", size, board),
        ("board_read_eeprom", None, board, u8),
        ("board_write_eeprom", None, board, u8),
        ("board_add_pca9685", None, board, ctypes.c_char, ctypes.c_int),
        ("board_fault_pca9685", None, board, ctypes.c_int),
        ("board_read_pca9685", u32, board, u8),
    ):
        function = getattr(lib, name)
        function.restype, function.argtypes = result, arguments
    return lib


@cache
def symbols(elf: Path) -> dict[str, int]:
    """Map the names of the ELF's RAM variables to their addresses in data memory."""
    listing = subprocess.run([COMPILER / "avr-nm", elf], text=True, capture_output=True, check=True)
    found = {}
    for row in listing.stdout.splitlines():
        address, kind, name = row.rsplit(" ", 2)
        if kind in "bBdD":
            found[name] = int(address, 16) & 0xFFFF
    return found


def wired(elf: Path, board: str, joints: int = 5, output: str = "servo") -> Board:
    """Power a board that has servos at its pins, all watched, or a PCA9685 and its /OE watched."""
    if output == "servo":
        return Board(elf, board, SERVO_PINS[board][: 2 * joints])
    powered = Board(elf, board, ENABLE_PIN[board])
    powered.add_pca9685(*DATA_WIRE[board])
    return powered


class Board:
    """A simulated board running one ELF; simulated time stands still between calls."""

    def __init__(self, elf: Path, board: str = "uno", pins: str = "", baud: int = 250_000):
        self.elf, self.mcu, self.baud = elf, BOARDS[board][0], baud
        self._lib = _library()
        self._board = self._lib.board_open(str(elf).encode(), self.mcu.encode(), F_CPU_HZ)
        if not self._board:
            raise RuntimeError(f"cannot run {elf} on {self.mcu}")
        for i in range(0, len(pins), 2):
            if self._lib.board_watch(self._board, pins[i].encode(), int(pins[i + 1])) < 0:
                raise ValueError(f"no pin {pins[i : i + 2]} on {self.mcu}")
        self._edges: list[np.ndarray] = []
        self._unread = bytearray()
        self._line: list[tuple[int, int]] = []  # (cycle, byte) of the line that has not ended
        self.lines: list[Line] = []
        self.runs = True

    def __enter__(self) -> Board:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the simulator."""
        if self._board:
            self._lib.board_close(self._board)
            self._board = None

    @property
    def cycle(self) -> int:
        """CPU cycles since power-on."""
        return self._lib.board_cycle(self._board)

    @property
    def time_s(self) -> float:
        """Simulated seconds since power-on."""
        return self.cycle / F_CPU_HZ

    @property
    def counts(self) -> Counts:
        """What the simulated hardware has counted so far."""
        return self._lib.board_counts(self._board)

    def run(self, seconds: float) -> None:
        """Let simulated time pass; `runs` is false once the program has crashed."""
        until = self.cycle + round(seconds * F_CPU_HZ)
        self.runs = bool(self._lib.board_run(self._board, until))
        self._collect()

    def run_until(self, wanted: str, timeout_s: float, step_s: float = 0.002) -> Line:
        """Run until a new line starts with `wanted`; return it, or raise AssertionError."""
        seen, end = len(self.lines), self.time_s + timeout_s
        while self.time_s < end:
            self.run(step_s)
            for line in self.lines[seen:]:
                if line.text.startswith(wanted):
                    return line
            seen = len(self.lines)
            assert self.runs, f"the board crashed before {wanted!r}"
        last = "\n".join(line.text for line in self.lines[-10:])
        raise AssertionError(f"no line {wanted!r} within {timeout_s} s; the last ones:\n{last}")

    def send(self, data: bytes, delay_s: float = 0.0) -> None:
        """Put bytes on the wire at its true pace, behind those already queued."""
        at = self.cycle + round(delay_s * F_CPU_HZ)
        self._lib.board_wire(self._board, at, self.baud, data, len(data))

    def read(self) -> bytes:
        """Return what the board has said since the last call."""
        said = bytes(self._unread)
        self._unread.clear()
        return said

    def reset(self, cause: str = "external") -> None:
        """Reset the processor; RAM and EEPROM keep their content."""
        self._lib.board_reset(self._board, CAUSES.index(cause))

    def hang(self) -> None:
        """Make the main program loop for ever at its present instruction, until a reset."""
        self._lib.board_hang(self._board)

    @property
    def static_ram(self) -> int:
        """Bytes of RAM that the program's variables take."""
        return symbols(self.elf)["_end"] - symbols(self.elf)["__data_start"]

    @property
    def stack_free(self) -> int:
        """Bytes between the variables and the deepest that the stack has been since power-on."""
        above = self.ram[symbols(self.elf)["_end"] :]
        return len(above) - len(above.lstrip(PAINT))

    @property
    def ram(self) -> bytes:
        """All data memory: registers, variables, stack; a variable's address is its index."""
        out = ctypes.create_string_buffer(RAM_END[self.mcu] + 1)
        self._lib.board_read_ram(self._board, 0, out, len(out))
        return out.raw

    def _address(self, symbol: str) -> int:
        known = symbols(self.elf)
        if symbol not in known:
            raise KeyError(f"{self.elf.name} has no RAM variable {symbol!r}")
        return known[symbol]

    def clock_offset_us(self) -> float:
        """Measure the cycle stamp at which the program's micros() was 0, to 10 us; takes 1 ms.

        The Arduino core counts the overflows of timer 0, one every 1024 us, in an interrupt.
        """
        address = self._address("timer0_overflow_count")

        def overflows() -> int:
            return int.from_bytes(self.ram[address : address + 4], "little")

        before = overflows()
        while overflows() == before:
            self.run(4e-6)
        return self.cycle * 1e6 / F_CPU_HZ - overflows() * 1024.0

    @property
    def eeprom(self) -> bytes:
        """The content of the EEPROM; assign to replace all of it."""
        out = ctypes.create_string_buffer(self._lib.board_eeprom_size(self._board))
        self._lib.board_read_eeprom(self._board, out)
        return out.raw

    @eeprom.setter
    def eeprom(self, content: bytes) -> None:
        size = self._lib.board_eeprom_size(self._board)
        if len(content) != size:
            raise ValueError(f"EEPROM content has {len(content)} bytes, the chip has {size}")
        self._lib.board_write_eeprom(self._board, content)

    def add_pca9685(self, port: str, data_bit: int) -> None:
        """Connect a servo driver to the two wires; its data wire is a bit of a port."""
        self._lib.board_add_pca9685(self._board, port.encode(), data_bit)

    def fault_pca9685(self, fault: str) -> None:
        """Give the servo driver one of FAULTS; silent: it has no power."""
        self._lib.board_fault_pca9685(self._board, FAULTS.index(fault))

    @property
    def pca9685(self) -> bytes:
        """The servo driver's 256 registers, those of its outputs as they are in effect."""
        out = ctypes.create_string_buffer(256)
        self._lib.board_read_pca9685(self._board, out)
        return out.raw

    @property
    def pca9685_bursts(self) -> int:
        """How often the servo driver's outputs have changed, all in one."""
        return self._lib.board_read_pca9685(self._board, ctypes.create_string_buffer(256))

    @property
    def edges(self) -> np.ndarray:
        """Every edge of the watched pins so far: (cycle, pin, level)."""
        self._edges = [np.concatenate([np.empty(0, EDGE), *self._edges])]
        return self._edges[0]

    def pulses(self, pin: int) -> Pulses:
        """Return the complete pulses of one watched pin, numbered from 0."""
        mine = self.edges[self.edges["pin"] == pin]
        mine = mine[np.argmax(mine["level"] == 1) :]
        cycle = mine["cycle"].astype(np.int64)
        n = len(mine) // 2
        rise, fall = cycle[0 : 2 * n : 2], cycle[1 : 2 * n : 2]
        return Pulses(rise, (fall - rise) * (1e6 / F_CPU_HZ))

    def _take(self, take: ctypes._CFuncPtr, dtype: np.dtype) -> np.ndarray:
        parts = []
        while True:
            part = np.empty(65536, dtype)
            n = take(self._board, part.ctypes.data, len(part))
            parts.append(part[:n])
            if n < len(part):
                return np.concatenate(parts)

    def _collect(self) -> None:
        edges = self._take(self._lib.board_take_edges, EDGE)
        if len(edges):
            self._edges.append(edges)
        for cycle, value, _ in self._take(self._lib.board_take_sent, SENT).tolist():
            self._unread.append(value)
            self._line.append((cycle, value))
            if value == ord("\n"):
                text = bytes(v for _, v in self._line).decode("ascii", "replace").rstrip("\r\n")
                self.lines.append(Line(self._line[0][0], text))
                self._line.clear()
