"""The playground's own arithmetic, in Node, with a core that answers by a formula."""

from __future__ import annotations

import json
import math
import shutil
import subprocess
from pathlib import Path

import pytest
from serpenoid.periodic.servo_steady import band

pytestmark = pytest.mark.skipif(not shutil.which("node"), reason="needs Node")
PARTS = Path(__file__).resolve().parents[2] / "docs" / "playground"
LOAD = """const vm = require('vm'), fs = require('fs');
globalThis.serpenoidCore = () => new Promise(() => {}), globalThis.onmessage = null;
globalThis.postMessage = () => {};
for (const name of ['model.js', 'worker.js'])
  vm.runInThisContext(fs.readFileSync(process.argv[1] + '/' + name, 'utf8'));
vm.runInThisContext(fs.readFileSync(0, 'utf8'));
"""


def asked(script: str):
    """Return what a script says that knows the page's model and its worker."""
    called = ["node", "-e", LOAD, str(PARTS)]
    done = subprocess.run(called, input=script, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


@pytest.mark.parametrize(
    ("hz", "frame_s", "longest_s"), [(1.0, 0.02, 1e-3), (0.4, 0.02, 2e-3), (1.0, 0.002, 5e-4)]
)
def test_servos_are_stepped_finely_enough(hz, frame_s, longest_s) -> None:
    """A millisecond; two where a period is longer than two seconds; a quarter of a frame."""
    steps = asked(f"""
globalThis.TABLES = {{servos: {{some: [{frame_s}]}}, servoFields: ['frame_s']}};
let step = 0;
const module_ = {{HEAPF64: new Float64Array(64), _malloc: () => 0,
  _serpenoid_servo: (at, servo, longest) => {{ step = longest; return 1; }}}};
new Core(module_).withServo({{...PRESETS['2005'], hz: {hz}}}, 'some');
console.log(step);""")
    assert steps == pytest.approx(longest_s)


def test_a_torque_claims_what_half_the_times_would_miss() -> None:
    """Between its times a torque may be higher still; at half of them this one is 0.71."""
    torques = [math.sin(math.tau * k / 8 + math.pi / 4) for k in range(9)]
    rows = [number for torque in torques for number in (*[0.0] * 10, torque)]
    told = asked(
        f"console.log(JSON.stringify(peakTorque({{links: 2, frames: 8, row: 11, data: {rows}}})))"
    )
    assert told["value"] == pytest.approx(1.0)
    assert told["error"] == pytest.approx(1.0 - math.sqrt(0.5))


def test_the_power_is_that_of_the_speed_asked() -> None:
    """Speed and power by the rate: the power belongs to the speed to a two-hundredth."""
    power = asked("""
core = {steady: (s) => ({known: true, speed: s.hz ** 0.8, power: s.hz ** 0.8})};
console.log(JSON.stringify([0.5, 1, 1.03, 2].map((hz) => powerFor({hz}, 1))));""")
    assert power == pytest.approx([1.0] * 4, abs=0.005)


@pytest.mark.parametrize("count", [16, 64])
def test_a_band_is_the_packages(count: int) -> None:
    drawn = [math.sin(k * k) for k in range(count)]
    ends = asked(f"console.log(JSON.stringify(band({json.dumps(drawn)})))")
    assert ends == pytest.approx(band(drawn), rel=1e-7)
