"""Measure flash, RAM and times of the firmware on each chip, and print them with their limits."""

from __future__ import annotations

import random
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # A run as a script finds it there

import numpy as np
from avr.board import SERVO_PINS, Board, wired
from avr.dialogue import Dialogue, telemetry
from avr.toolchain import COMPILER, build_firmware
from avr.truth import Wave, pulse_errors_us

BOARDS = ("uno", "mega")
FLASH = {"uno": 30_720, "mega": 60_000}  # bytes: a Nano's, less its boot loader
MIN_UNTOUCHED_RAM = 250  # bytes that no command ever touches, with the largest number of joints
MEMORY_S = 12.0  # simulated time of one row of the table of memory
COMMAND_S = 0.0097  # time between commands, no fraction of a frame: they come at all its parts


@dataclass(frozen=True)
class Row:
    """One line of the budget: a measured value, its bound, and whether the bound is a floor."""

    item: str
    unit: str
    value: float
    bound: float
    floor: bool = False

    @property
    def is_kept(self) -> bool:
        """Whether the value is within its bound."""
        return self.value >= self.bound if self.floor else self.value <= self.bound


def flash_bytes(elf: Path) -> int:
    """Return the program memory that the ELF takes: code and initial values."""
    listing = subprocess.run(
        [COMPILER / "avr-size", "-A", "-d", elf], text=True, capture_output=True, check=True
    )
    rows = [line.split() for line in listing.stdout.splitlines()]
    return sum(int(row[1]) for row in rows if row[:1] in ([".text"], [".data"]))


def busy_board(elf: Path, name: str, seconds: float) -> tuple[Dialogue, int]:
    """Run a gait with telemetry and commands; return the dialogue and its first line then."""
    dialogue = Dialogue(Board(elf, name, SERVO_PINS[name]))
    dialogue.obey("hello", "gait 30 80 5", "ping", "help", "set", "trim", "status")
    dialogue.keep_alive(4.0)
    first = len(dialogue.board.lines)
    for i in range(int(seconds / COMMAND_S)):
        dialogue.send("status" if i % 10 == 0 else "ping")
        dialogue.board.run(COMMAND_S)
    return dialogue, first


def random_command(rng: random.Random, joints: int = 5) -> str:
    """Return a command, valid or invalid, with random fields."""
    number = f"{rng.uniform(-120, 120):.{rng.randrange(7)}f}"
    return rng.choice(
        [
            f"gait {rng.uniform(0, 95):.4f} {rng.uniform(-185, 185):.6f} {rng.uniform(0, 12):.3f}",
            f"gait 30.123456 -80.654321 5.123456 {rng.uniform(-60, 60):.6f}",
            "pose " + " ".join(f"{rng.uniform(-95, 95):.6f}" for _ in range(joints)),
            f"pose straight {number}",
            f"set {rng.choice(('angle_ramp', 'pose_speed', 'every', 'limp', 'colour'))} {number}",
            f"trim {rng.randrange(7)} {rng.choice(('centre', 'low', 'high', 'scale'))} {number}",
            *("help", "set", "trim", "status", "stop", "idle", "save", "save unattended", "load"),
            *("defaults", "hello", "ping", "pose straight", "nonsense", "x" * rng.randrange(90)),
        ]
    )


def run_random_commands(
    elf: Path, name: str, seconds: float, joints: int = 5, output: str = "servo"
) -> tuple[int, int]:
    """Send random commands and damage; return RAM never touched, bytes, and latest frame, µs."""
    rng = random.Random(2005)
    with wired(elf, name, joints, output) as board:
        dialogue = Dialogue(board)
        dialogue.obey("hello")
        end_s = board.time_s + seconds
        while board.time_s < end_s:
            dialogue.send(random_command(rng, joints))
            if rng.random() < 0.1:
                board.send(bytes(rng.randrange(256) for _ in range(30)) + b"\n!\n")
            board.run(rng.uniform(0.002, 0.08))
        board.run(0.5)  # The board loses bytes when its buffer is full, perhaps the end of a line.
        board.send(b"\n")
        board.run(0.1)
        return board.stack_free, dialogue.counters()["late_us"]


def measure(name: str, seconds: float = 10.0) -> list[Row]:
    """Return the measured rows of one board, in the order of the table."""
    elf = build_firmware(name)
    untouched, _ = run_random_commands(elf, name, 4 * seconds)
    dialogue, first = busy_board(elf, name, seconds)
    with dialogue.board as board:
        frames = telemetry(board.lines[first:])
        angles_rad = np.radians([30.0, 80.0])
        wave = Wave(*angles_rad, 5.0, int(frames.frame[0]), float(frames.phase_rad[0]))
        errors = pulse_errors_us(board, frames, wave)
        counters = dialogue.counters()
        return [
            Row("flash", "bytes", flash_bytes(elf), FLASH[name]),
            Row("static RAM", "bytes", board.static_ram, 1_600),
            Row("RAM never touched, any commands", "bytes", untouched, 500, floor=True),
            Row("setpoints to pulses, mean", "µs", float(np.mean(frames.exec_us)), 800),
            Row("setpoints to pulses, worst", "µs", float(np.max(frames.exec_us)), 1_000),
            Row("whole frame, worst", "µs", counters["longest_pass_us"], 5_000),
            Row("lateness of a frame, worst", "µs", counters["late_us"], 2_000),
            Row("frames missed", "", counters["overruns"], 0),
            Row("received bytes lost", "", board.counts.overrun_bytes + counters["rxfull"], 0),
            Row("pulse error, mean", "µs", abs(float(np.mean(errors))), 1.0),
            Row("pulse error, s.d.", "µs", float(np.std(errors)), 1.0),
            Row("pulse error, 99 % within", "µs", float(np.percentile(abs(errors), 99)), 3.0),
            Row("pulse error, extreme", "µs", float(np.max(abs(errors))), 10.0),
        ]


def memory(name: str, joints: int, output: str) -> tuple[int, int, int, int]:
    """Return flash, static RAM, RAM never touched, all in bytes, and the latest frame, µs."""
    elf = build_firmware(name, joints, output)
    with Board(elf, name) as board:
        static = board.static_ram
    return flash_bytes(elf), static, *run_random_commands(elf, name, MEMORY_S, joints, output)


def markdown(headings: list[str], rows: list[list[object]]) -> str:
    """Return a Markdown table."""
    lines = [headings, ["---"] * len(headings), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)


def main() -> None:
    """Print both tables of firmware/README.md: the budget, and memory by number of joints."""
    rows = []
    for board_rows in zip(*map(measure, BOARDS), strict=True):
        first = board_rows[0]
        values = [f"{row.value:.6g}" for row in board_rows]
        bound = f"{'≥' if first.floor else '≤'} {first.bound:g} {first.unit}".rstrip()
        rows.append([first.item, bound, *values])
    print(markdown(["item", "budget", *BOARDS], rows), end="\n\n")
    headings = "board, output, joints, flash, static RAM, never touched, latest frame in µs"
    cases = [("uno", n) for n in (2, 5, 6, 7, 8)] + [("mega", 5), ("mega", 12)]
    built = [(name, output, joints) for output in ("servo", "pca9685") for name, joints in cases]
    rows = [[name, out, joints, *memory(name, joints, out)] for name, out, joints in built]
    print(markdown(headings.split(", "), rows))


if __name__ == "__main__":
    main()
