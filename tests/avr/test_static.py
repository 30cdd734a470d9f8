"""The firmware as compilers and checkers read it: no warning from a file of ours."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest
from avr.toolchain import BUILD, ROOT, pio

pytestmark = pytest.mark.avr

LIBRARIES = sorted((ROOT / "firmware" / "lib").iterdir())
# Off: what clang-tidy cannot know of this code. Flash tables look like dynamic initializers, the
# linker's _end is reserved on purpose, sizes of our structures are far below 256, and parameters
# of one type next to each other are the usual case in arithmetic.
CHECKS = (
    "-*,bugprone-*,clang-analyzer-*,-bugprone-dynamic-static-initializers,"
    "-bugprone-reserved-identifier,-bugprone-too-small-loop-variable,"
    "-bugprone-easily-swappable-parameters,-bugprone-macro-parentheses"
)
# clang cannot read the assembly in avr-libc's watchdog header.
UNREADABLE = ("main.cpp", "start.cpp")


def need(tool: str) -> str:
    found = shutil.which(tool)
    if not found and os.environ.get("CI") == "true":
        pytest.fail(f"{tool} is missing")
    return found or pytest.skip(f"{tool} is missing")


@pytest.mark.parametrize("board", ["uno", "nano", "mega"])
def test_no_compiler_warning(firmware_elf, board):
    firmware_elf(board)
    shutil.rmtree(BUILD / "pio" / "build" / board)
    said = pio("run", "-e", board)
    ours = [line for line in said.splitlines() if "warning:" in line and "firmware/" in line]
    assert not ours
    assert "Compiling build/avr/pio/build/" in said, "nothing was compiled"


def test_cppcheck_finds_nothing():
    command = [need("cppcheck"), "--enable=warning,performance,portability", "--quiet"]
    command += ["--std=c++11", "--language=c++", "--error-exitcode=1", "-D__AVR_ATmega328P__"]
    command += [f"-I{path}" for path in (ROOT / "firmware" / "include", *LIBRARIES)]
    command += [str(ROOT / "firmware" / "src"), str(ROOT / "firmware" / "lib")]
    done = subprocess.run(command, text=True, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_clang_tidy_finds_nothing(firmware_elf, tmp_path):
    tidy = need("clang-tidy")
    firmware_elf("uno")
    flags = ["--target=avr", "-mmcu=atmega328p", "-std=gnu++11", "-isystem/usr/lib/avr/include"]
    flags += ["-Wno-everything", "-DF_CPU=16000000L", "-DARDUINO=10808", "-DARDUINO_ARCH_AVR"]
    core = BUILD / "core" / "packages" / "framework-arduino-avr"
    servo = BUILD / "pio" / "libdeps" / "uno" / "Servo" / "src"
    system = [servo, core / "cores" / "arduino", core / "variants" / "standard"]
    flags += [f"-isystem{path}" for path in system]
    flags += [f"-I{path}" for path in (ROOT / "firmware" / "include", *LIBRARIES)]
    sources = sorted(p for p in (ROOT / "firmware").rglob("*.cpp") if p.name not in UNREADABLE)
    entries = [
        {"directory": str(ROOT), "file": str(p), "arguments": ["clang++", *flags, "-c", str(p)]}
        for p in sources
    ]
    Path(tmp_path / "compile_commands.json").write_text(json.dumps(entries))
    command = [tidy, "--quiet", f"-p={tmp_path}", f"--checks={CHECKS}", "--warnings-as-errors=*"]
    command += [f"--header-filter={ROOT}/firmware/.*", *map(str, sources)]
    done = subprocess.run(command, text=True, capture_output=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
