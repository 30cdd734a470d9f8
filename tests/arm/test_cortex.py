"""The firmware's libraries on a Cortex-M in an emulator say what they say on this computer."""

from __future__ import annotations

import random
import shutil
import subprocess
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from avr.budget import random_command
from avr.dialogue import seal
from golden import dialogue
from serpenoid._core import firmware

HERE = Path(__file__).parent
LIBRARIES = HERE.parents[1] / "firmware" / "lib"
TOOLS = ("arm-none-eabi-gcc", "qemu-system-arm")
STEP_US = 40
CORES = ("cortex-m0plus", "cortex-m3")  # compiled for; the emulated machine runs both
FLAGS = "-mthumb -Os -std=gnu++11 -Wall -Wextra -Wconversion -Werror -fno-exceptions -fno-rtti"
LINK = "-fno-threadsafe-statics --specs=rdimon.specs"
LONG_S = 300.0

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not all(shutil.which(tool) for tool in TOOLS),
        reason=f"needs {' and '.join(TOOLS)}; Debian: gcc-arm-none-eabi, "
        "libnewlib-arm-none-eabi, qemu-system-arm",
    ),
]


class Twin:
    """The board of this computer, and the script of all that was done with it."""

    def __init__(self, joints: int = 5):
        self.board, self.script, self.said = firmware.Board(joints=joints), bytearray(), []
        self.board.boot()

    def write(self, data: bytes) -> None:
        self.script += b">%d %s" % (len(data), data)
        self.board.write(data)

    def run(self, seconds: float) -> None:
        self.script += b"~%d " % -(-round(seconds * 1e6) // STEP_US)
        self.board.run(seconds)

    def read(self) -> bytes:
        self.script += b"<"
        self.said.append(self.board.read())
        return self.said[-1]


@pytest.fixture(scope="module")
def cortex(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., list[bytes]]:
    """Return a function that plays a script on a core, and gives what was said at each read."""

    @cache
    def built(core: str, joints: int) -> Path:
        elf = tmp_path_factory.mktemp("cortex") / "board.elf"
        folders = [f"-I{folder}" for folder in LIBRARIES.iterdir()]
        sources = [HERE / "cortex.cpp", *sorted(LIBRARIES.glob("*/*.cpp"))]
        subprocess.run(
            [
                "arm-none-eabi-gcc",
                f"-mcpu={core}",
                *FLAGS.split(),
                *LINK.split(),
                *folders,
                f"-DSERPENOID_JOINTS={joints}",
                "-T",
                HERE / "cortex.ld",
                *sources,
                "-o",
                elf,
                "-lm",
            ],
            check=True,
        )
        return elf

    def play(core: str, script: bytes, joints: int = 5) -> list[bytes]:
        elf = built(core, joints)
        (elf.parent / "script").write_bytes(script)
        subprocess.run(
            [
                "qemu-system-arm",
                "-M",
                "mps2-an385",
                "-display",
                "none",
                "-serial",
                "none",
                "-monitor",
                "none",
                "-semihosting-config",
                "enable=on,target=native",
                "-kernel",
                elf,
            ],
            check=True,
            cwd=elf.parent,
            stdin=subprocess.DEVNULL,
            timeout=LONG_S,
        )
        return (elf.parent / "said").read_bytes().split(b"\0")[:-1]

    return play


@pytest.mark.parametrize("core", CORES)
def test_the_golden_dialogue(cortex, core):
    twin = Twin()
    assert dialogue.play(twin.write, twin.run, twin.read, timed=True) > 100
    assert cortex(core, twin.script) == twin.said


@pytest.mark.parametrize("joints", [5, 12])
def test_any_commands(cortex, joints):
    """Commands right and wrong, sealed and bare, and damage, over a minute of motion."""
    rng = random.Random(12)
    twin = Twin(joints)
    twin.write(seal("#0 hello"))
    for number in range(1, 800):
        text = random_command(rng)
        twin.write(seal(f"#{number} {text}") if rng.random() < 0.9 else text.encode() + b"\n")
        if rng.random() < 0.05:
            twin.write(bytes(rng.randrange(256) for _ in range(30)) + b"\n!\n")
        twin.run(rng.uniform(0.002, 0.15))
        twin.read()
    twin.run(1.0)
    heard = b"".join([*twin.said, twin.read()])
    assert heard.count(b" st=gait ") > 300
    assert cortex("cortex-m3", twin.script, joints) == twin.said
