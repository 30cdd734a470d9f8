"""Fits of friction: known answers, honest intervals, and an independent solver to agree with."""

import subprocess
import sys
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from calibration.synthetic_session import WHOLE_BODY_2005, session, setup
from odrpack import odr_fit
from refusals import refused
from robots import NIRAKH_2005
from serpenoid import fit_friction, load_session
from serpenoid.friction.fit import map_estimate
from serpenoid.friction.parameters import FRICTIONS

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


# Two bends' errors correlate by a quarter, as the fit's head says.
TOGETHER = 0.25


def whole_problem(made):
    """Return what the two solvers below need: readings, uncertainties, gamma(v, parameters).

    parameters: ct, cn, ft0, fn0, the inclinometer's zero, then every bend's offset in sigmas.
    """
    unit, kept = made.setup.instruments, made.kept_stations
    bend = np.array([r.lambda_rad for r in kept])
    shown = np.array([r.incline_rad for r in kept])
    speed = np.array([r.slip_speed_m_s for r in kept])
    bends = np.unique(bend[bend > 0])
    whose = np.searchsorted(bends, bend)

    def incline(v, parameters):
        ct, cn, ft0, fn0, zero = parameters[:5]
        angle = bend + (bend > 0) * (unit.lambda_sigma_rad * parameters[5:])[whose]
        c, s = np.cos(angle), np.sin(angle)
        force = (ct * v * c + ft0) * c + (cn * v * s + fn0) * s
        return np.arcsin(force / made.setup.weight_n) + zero

    correlation = TOGETHER + (1 - TOGETHER) * np.eye(len(bends))
    return unit, shown, speed, incline, np.linalg.inv(np.linalg.cholesky(correlation))


def odrpack_fit(made):
    """Solve the same problem by ODRPACK, the priors as one more observation each."""
    unit, shown, speed, incline, whiten = whole_problem(made)
    extra = 1 + len(whiten)
    sigmas = np.concatenate(
        [
            np.full(len(speed), unit.incline_sigma_rad),
            [unit.incline_zero_sigma_rad],
            np.ones(extra - 1),
        ]
    )
    found = odr_fit(
        lambda x, beta: np.concatenate([incline(x[:-extra], beta), beta[4:5], whiten @ beta[5:]]),
        np.concatenate([speed, np.zeros(extra)]),
        np.concatenate([shown, np.zeros(extra)]),
        np.concatenate([TRUTH, [1e-3], np.full(extra - 1, 0.1)]),
        weight_x=1 / unit.belt_speed_sigma_m_s**2,
        weight_y=1 / sigmas**2,
        fix_x=np.array([False] * len(speed) + [True] * extra),
        diff_scheme="central",
        sstol=1e-14,
        partol=1e-12,
        maxit=500,
    )
    return found.beta[:4], found.cov_beta[:4, :4], found.sum_square


@pytest.mark.parametrize(("seed", "lambdas_deg"), [(0, (7.5,)), (1, (7.5, 15.0, 30.0))])
def test_joint_fit_solves_the_whole_problem(seed, lambdas_deg):
    """ODRPACK differentiates numerically: its covariance is right to 1 %, its values are exact."""
    made = session(setup(*lambdas_deg), WHOLE_BODY_2005, np.random.default_rng(seed))
    fit, (found, covariance, chi2) = fit_friction(made), odrpack_fit(made)
    # Ours takes the incline as linear in the force over its error of 0.03 degrees, which moves a
    # residual by 1e-5 of itself.
    np.testing.assert_array_less(np.abs(values(fit) - found), 1e-4 * sigmas(fit))
    assert fit.chi2 == pytest.approx(chi2, rel=1e-4)
    # In standard deviations, so that small correlations are not asked for to a relative error.
    linear = map_estimate(made).covariance[:4, :4]
    sigma = np.sqrt(np.diag(linear))
    unit = np.outer(sigma, sigma)
    np.testing.assert_allclose(linear / unit, covariance / unit, rtol=0, atol=0.02)


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (
            lambda s: [r for r in s.readings if r.lambda_rad == 0],
            "cn and fn0 cannot be told from 0 bent.*at least 2, with lambda_deg = 15",
        ),
        (lambda s: [r for r in s.readings if r.lambda_rad > 0], "0 straight reading.*at least 2"),
        (lambda s: s.readings[4:], "ct and ft0 cannot be told from 1 straight reading.*at least 2"),
        (lambda s: [replace(r, belt_speed_m_s=0.5) for r in s.readings], "span at least four"),
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


def test_a_fit_imports_few_modules_and_no_statistics():
    code = f"""if True:
        import sys
        import serpenoid as sn
        sn.fit_friction(sn.load_session({str(NIRAKH_2005)!r}))
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
