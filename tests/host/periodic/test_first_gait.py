"""A first gait starts fast, because modules that it does not need are not imported."""

import subprocess
import sys


def test_a_gait_without_servos_imports_nothing_for_them() -> None:
    code = """if True:
        import sys
        import serpenoid as sn
        sn.steady_gait(sn.Robot(6, 1.0, 0.12), sn.Ground(0.1, 10.0), sn.Gait(0.5, 1.4, 5.0))
        print({"concurrent.futures", "serpenoid.model.drives", "scipy"} & set(sys.modules))"""
    result = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    )
    assert result.stdout.strip() == "set()"
