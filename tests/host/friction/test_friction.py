"""Fits of friction: known answers, honest intervals, and what an independent solver found."""

import math
import subprocess
import sys
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from calibration.floor_sessions import short_session
from calibration.synthetic_session import WHOLE_BODY_2005, session, setup
from refusals import refused
from robots import NIRAKH_2005
from serpenoid import fit_friction, load_session
from serpenoid.session.journal import Journal
from serpenoid.taking.new_session import create_session

FRICTIONS = ("ct", "cn", "ft0", "fn0")
TRUTH = np.array([getattr(WHOLE_BODY_2005, name) for name in FRICTIONS])


def values(fit):
    return np.array([fit.parameters[name].value for name in FRICTIONS])


def sigmas(fit):
    return np.array([fit.parameters[name].sigma for name in FRICTIONS])


@pytest.mark.parametrize("method", ["joint", "naive"])
def test_2005_readings_give_back_the_published_lines(method):
    fit = fit_friction(load_session(NIRAKH_2005), method=method)
    # Speeds are rounded to 1e-6 m/s, 5e-5 of the 0.02 m/s that scatters cn by 35 %: at most 2e-5.
    np.testing.assert_allclose(values(fit), TRUTH, rtol=2e-5)
    np.testing.assert_allclose([getattr(fit.ground, n) for n in FRICTIONS], TRUTH / 6, rtol=2e-5)
    np.testing.assert_allclose(sigmas(fit) ** 2, np.diag(fit.covariance), rtol=1e-12)
    for name, truth in zip(FRICTIONS, TRUTH, strict=True):
        low, high = fit.intervals[name]
        assert 0.0 <= low < truth < high
    assert fit.dof == 7
    assert fit.chi2 < 1e-6
    assert any("regenerated" in note for note in fit.notes)


# What ODRPACK 2.01 finds of the whole problem as it stands, errors of bends by a correlation of a
# quarter and of the zero as parameters: values, their sigmas (to 1 %, of differences), chi2.
BY_ODRPACK = {
    (7.5,): (
        [0.0882370744, 0.8053710290, 0.1355261919, 0.3157567672],
        [0.00464710, 0.39641419, 0.00828040, 0.03547523],
        6.0682889,
    ),
    (7.5, 15.0, 30.0): (
        [0.0828880253, 1.2112128942, 0.1322914732, 0.2689312286],
        [0.00330167, 0.04206682, 0.00794164, 0.00824658],
        39.4177630,
    ),
}


@pytest.mark.parametrize(("seed", "lambdas_deg"), list(enumerate(BY_ODRPACK)))
def test_joint_fit_solves_the_whole_problem(seed, lambdas_deg):
    planned = setup(*lambdas_deg, kind="regenerated")  # its belt runs as its instruments state
    fit = fit_friction(session(planned, WHOLE_BODY_2005, np.random.default_rng(seed)))
    found, sigma, chi2 = BY_ODRPACK[lambdas_deg]
    # Ours takes the incline as linear in the force over its error of 0.03 degrees, which moves a
    # residual by 1e-5 of itself.
    np.testing.assert_array_less(np.abs(values(fit) - found), 1e-4 * sigmas(fit))
    assert fit.chi2 == pytest.approx(chi2, rel=1e-4)
    np.testing.assert_allclose(sigmas(fit), sigma, rtol=0.08)  # of draws, and skewed


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (
            lambda s: [r for r in s.readings if r.lambda_rad == 0],
            "cn and fn0 cannot be told from 0 bent.*at least 2, with lambda_deg = 15",
        ),
        (lambda s: [r for r in s.readings if r.lambda_rad > 0], "0 straight reading.*at least 2"),
        (lambda s: s.readings[4:], "ct and ft0 cannot be told from 1 straight reading.*at least 2"),
        (
            lambda s: [replace(r, belt_speed_m_s=0.5) for r in s.readings],
            "whose speeds span 0 m/s; .*belt speeds span 0.08 m/s",
        ),
        (
            lambda s: [replace(r, lambda_rad=r.lambda_rad / 6) for r in s.readings],
            r"cn and fn0 cannot be told: lambda_deg is 1\.25 with .* 0\.5; .*lambda_deg = 15",
        ),
    ],
)
def test_too_little_to_fit_is_refused(spoil, says):
    made = session(setup(7.5), WHOLE_BODY_2005)
    with refused(says):
        fit_friction(replace(made, readings=tuple(spoil(made))))


@pytest.mark.parametrize("place", ["belt", "floor"])
def test_a_fit_imports_few_modules_and_no_statistics(place, tmp_path):
    folder = str(NIRAKH_2005)
    if place == "floor":
        pushes = short_session()
        folder = str(create_session(tmp_path / "s", pushes.setup))
        with Journal(folder) as journal:
            for push in pushes.readings:
                cells = {"lambda_deg": math.degrees(push.lambda_rad), "way": push.way, "by": "film"}
                journal.add("push", cells, samples=push.track.values)
    code = f"""if True:
        import sys
        import serpenoid as sn
        sn.fit_friction(sn.load_session({folder!r}))
        ours = [name for name in sys.modules if name.startswith("serpenoid")]
        print(len(ours), "scipy.stats" in sys.modules)
    """
    told = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    modules, statistics = told.stdout.split()
    assert int(modules) <= 35
    assert statistics == "False"


def test_result_is_frozen_and_goes_to_a_table():
    fit = fit_friction(load_session(NIRAKH_2005))
    with pytest.raises(FrozenInstanceError):
        fit.chi2 = 0.0
    with pytest.raises(ValueError, match="read-only"):
        fit.covariance[0, 0] = 0.0
    with pytest.raises(TypeError):
        fit.parameters["ct"] = (0.0, 0.0)
    told = fit.to_dict()
    assert told["parameters"]["ct_whole"]["value"] == fit.parameters["ct_whole"].value
    assert told["ground_per_link"]["ct"] == pytest.approx(fit.parameters["ct"].value / 6)
