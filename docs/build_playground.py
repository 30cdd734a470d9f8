"""Build the playground: the core as WebAssembly, embedded in one page that needs no network."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from importlib.resources import files
from pathlib import Path

import numpy as np
from serpenoid._core import SERVO_FIELDS
from serpenoid.model.drives import Servo, ServoKind
from serpenoid.periodic.servo_steady import band
from serpenoid.servos.catalogue import SERVOS
from serpenoid.servos.speed_limit import MAX_NO_LOAD_SHARE, no_load_rad_s

SAMPLES = 128  # servos of a kind: their band is within a tenth of the package's 512
ROOT = Path(__file__).resolve().parents[1]
CORE, FIRMWARE, PARTS = (
    ROOT / "host" / "core",
    ROOT / "firmware" / "lib",
    ROOT / "docs" / "playground",
)
# Not in a browser: Python's glue, boards, what the page does not ask.
LEFT_OUT = ("python", "board", "lab")
FLAGS = [
    "-std=c++20",
    "-O2",
    "-DNDEBUG",
    "-fexceptions",
    "-ffp-contract=off",
    "-fno-math-errno",
    f"-I{CORE}",
    f"-I{FIRMWARE / 'gait'}",
    f"-I{FIRMWARE / 'avr'}",
]
LINK = [
    "-sMODULARIZE=1",
    "-sEXPORT_NAME=serpenoidCore",
    "-sSINGLE_FILE=1",
    "-sALLOW_MEMORY_GROWTH=1",
    "-sENVIRONMENT=web,worker,node",
    "-sFILESYSTEM=0",
    "-O2",
    "-fexceptions",
    "-sEXPORTED_FUNCTIONS=_serpenoid_ideal,_serpenoid_servos,_serpenoid_motion,_malloc,_free",
    "-sEXPORTED_RUNTIME_METHODS=HEAPF64",
]


def _run(command: list[str]) -> None:
    # Debian's emscripten looks for acorn where Debian's node does not
    environment = os.environ | {"NODE_PATH": "/usr/share/nodejs"}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    if done.returncode:
        raise SystemExit(f"{' '.join(command[:3])} ... failed:\n{done.stderr[-3000:]}")


def compile_core(build: Path) -> Path:
    """Compile what is newer than its object, link it, and return the module's script."""
    build.mkdir(parents=True, exist_ok=True)
    sources = sorted(CORE.rglob("*.cpp"))
    sources = [p for p in sources if p.relative_to(CORE).parts[0] not in LEFT_OUT]
    sources += sorted(FIRMWARE.glob("gait/*.cpp"))
    headers = [*CORE.rglob("*.hpp"), *FIRMWARE.glob("*/*.h"), Path(__file__)]
    newest = max(p.stat().st_mtime for p in headers)
    objects = {p: build / f"{p.parent.name}_{p.stem}.o" for p in sources}
    old = [
        p
        for p, o in objects.items()
        if not o.exists() or o.stat().st_mtime < max(newest, p.stat().st_mtime)
    ]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(lambda p: _run(["em++", *FLAGS, "-c", str(p), "-o", str(objects[p])]), old))
    module = build / "core.js"
    _run(["em++", *map(str, objects.values()), *LINK, "-o", str(module)])
    return module


def servo_fields(servo: Servo) -> list[float]:
    """Return the fields of a servo in the order that the core takes them, to five digits."""
    return [float(f"{getattr(servo, name):.5g}") for name in SERVO_FIELDS]


def _kind(kind: ServoKind) -> dict[str, object]:
    """Return the typical servo of a kind, samples of it, and the fastest joint rate, rad/s."""
    return {
        "typical": servo_fields(kind.servo),
        "samples": [servo_fields(servo) for servo in kind.draws(SAMPLES)],
        "limitRadS": MAX_NO_LOAD_SHARE * no_load_rad_s(kind),
    }


def low_end_weights() -> list[float]:
    """Return the weight of each of SAMPLES sorted values in the lower end of their band.

    Read off the steps: the band of values that are 0 below the k-th one and 1 from it on. The
    upper end has the same weights in reverse order.
    """
    order = np.arange(SAMPLES)
    return (-np.diff([band(order >= k)[0] for k in range(SAMPLES + 1)])).tolist()


def tables() -> str:
    """Return what the page takes from the package: kinds of servos, and weights of a band."""
    kinds = {name: _kind(kind) for name, kind in SERVOS.items()}
    data = {"lowEndWeights": low_end_weights(), "servos": kinds}
    return f"const TABLES = {json.dumps(data, separators=(',', ':'))};\n"


def page(module: Path) -> str:
    """Return the page with its style, its scripts and the module inside."""
    text = (PARTS / "page.html").read_text(encoding="utf-8")
    names = ("playground.css", "shared.js", "worker.js", "draw.js", "page.js")
    scripts = {name: (PARTS / name).read_text(encoding="utf-8") for name in names}
    snake = files("serpenoid") / "show" / "pages" / "snake.js"  # as `serpenoid view` draws it
    scripts["snake.js"] = snake.read_text(encoding="utf-8")
    scripts["core.js"] = module.read_text(encoding="utf-8")
    scripts["tables.js"] = tables()
    module.with_name("tables.js").write_text(scripts["tables.js"], encoding="utf-8")
    for name, content in scripts.items():
        text = text.replace(f"/*{name}*/", content.replace("</script", "<\\/script"))
    return text


def build(folder: Path, standalone: bool = False) -> bool:
    """Write the page into a folder; False, and a line that says so, without emscripten.

    alone: no documentation stands beside it, and it has no link there.
    """
    if not shutil.which("em++"):
        print("no playground: emscripten is not here (Debian: apt-get install emscripten)")
        return False
    folder.mkdir(parents=True, exist_ok=True)
    text = page(compile_core(ROOT / "build" / "web"))
    if standalone:
        text = re.sub(r'<a [^>]*id="home">.*?</a>', "", text)
    (folder / "index.html").write_text(text, encoding="utf-8")
    return True


if __name__ == "__main__":
    sys.exit(not build(Path(sys.argv[1]), "--alone" in sys.argv))
