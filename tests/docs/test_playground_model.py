"""The playground's own arithmetic, in Node, with the package's tables and no core."""

from __future__ import annotations

import json
import math
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import serpenoid as sn
from serpenoid.periodic.servo_steady import band
from serpenoid.servos.speed_limit import highest_hz

pytestmark = pytest.mark.skipif(not shutil.which("node"), reason="needs Node")
DOCS = Path(__file__).resolve().parents[2] / "docs"
LOAD = """const vm = require('vm'), fs = require('fs');
globalThis.serpenoidCore = () => new Promise(() => {}), globalThis.onmessage = null;
const given = JSON.parse(fs.readFileSync(0, 'utf8'));
vm.runInThisContext(given.tables);
for (const name of ['shared.js', 'worker.js'])
  vm.runInThisContext(fs.readFileSync(process.argv[1] + '/playground/' + name, 'utf8'));
vm.runInThisContext(given.script);
"""


@pytest.fixture(scope="module")
def tables() -> str:
    printed = "import build_playground; print(build_playground.tables())"
    called = [sys.executable, "-c", printed]
    return subprocess.run(called, cwd=DOCS, capture_output=True, text=True, check=True).stdout


def javascript_value(tables: str, script: str):
    """Return what a script says that knows the page's tables and its worker."""
    request = json.dumps({"tables": tables, "script": f"console.log(JSON.stringify({script}))"})
    called = ["node", "-e", LOAD, str(DOCS)]
    done = subprocess.run(called, input=request, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def test_a_range_is_the_packages_band(tables) -> None:
    speeds = [2 + math.sin(k * k) for k in range(128)]
    ends = javascript_value(
        tables,
        f"""(() => {{
const core = new Core(null);
core.servoSpeeds = (s, servos, rough) => (rough ? [2, ...{json.dumps(speeds)}] : [1]);
return core.range({{servo: 'hobby'}}); }})()""",
    )
    assert ends == pytest.approx([end / 2 for end in band(speeds)], rel=1e-7)


def test_the_highest_frequency_is_the_packages(tables) -> None:
    gait = sn.Gait(math.radians(50), math.radians(75), 3.0)
    for name in ("hobby", "SG90"):
        answer = javascript_value(tables, f"highestHz({{alpha: 50, servo: '{name}'}})")
        assert answer == pytest.approx(highest_hz(gait, sn.servo(name)))


def test_the_core_is_given_one_link_and_radians(tables) -> None:
    answers = javascript_value(
        tables,
        """new Core(null).scene({links: 4, mass: 2, length: 0.1, ct: 0.4, cn: 8, ft0: 0.8, fn0: 1.2,
alpha: 90, beta: 45, hz: 0.5})""",
    )
    expected = [4, 0.5, 0.1, 0.1, 2, 0.2, 0.3, math.pi / 2, math.pi / 4, math.pi]
    assert answers == pytest.approx(expected)
