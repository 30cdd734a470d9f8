"""Friction of the whole snake fitted to a calibration session (Eqs. 58-62), with honest intervals.

On a treadmill inclined by gamma the snake holds its station where, over the whole body of weight
m g, with every link turned by lambda to the direction of the belt (Eq. 60; Eq. 58 if straight),

    m g sin(gamma) = F_t cos(lambda) + F_n sin(lambda) = A v + B,
    F_t = ct v cos(lambda) + ft0,    F_n = cn v sin(lambda) + fn0,
    A = ct cos^2(lambda) + cn sin^2(lambda),    B = ft0 cos(lambda) + fn0 sin(lambda).

The joint fit is an errors-in-variables fit of all readings at once. Unknown are the four
parameters, the true belt speed v_i of every reading, an offset d of lambda common to all bent
readings and the inclinometer's zero z; the last two have priors. A straight snake is taken to be
straight. It minimises

    sum ((v_i' - v_i) / sv)^2 + ((gamma_i' - z - gamma(v_i)) / sg)^2 + (d / sd)^2 + (z / sz)^2.

Because the balance is linear in v_i, and m g sin(gamma) is over a reading's sg, every v_i can be
solved for by hand; what is left of a reading is one residual, the distance to the line:

    r_i = (m g sin(gamma_i' - z) - A v_i' - B) / s_i,
    s_i^2 = (m g cos(gamma_i' - z) sg)^2 + (A sv)^2,

and six unknowns. The full problem's covariance is kept: eliminating the v_i by hand is the Schur
complement that a solver would form. The naive fit is the paper's own: a straight line through the
straight readings, Eq. 61, and a straight line through what it gives.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..model.checks import check_choice
from ..model.errors import BadInput, NotConverged
from ..model.ground import Ground
from .friction_result import DOUBTFUL, LEVEL, NAMES, UNITS, Estimate, Floats, FrictionFit, notes_on
from .session import Session

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

METHODS = ("joint", "naive")


def fit_friction(session: Session, *, method: str = "joint") -> FrictionFit:
    """Fit ct, cn, ft0 and fn0 to a session's kept readings.

    method: "joint" (errors in variables, all readings at once, no parameter below 0; sigma is
    absolute, never rescaled by the scatter: chi2 tells whether the stated uncertainties hold) or
    "naive" (the paper's Eq. 61 and two straight lines; sigma rescaled). Raises BadInput if the
    readings cannot determine all four: fewer than two straight or two bent ones (three if naive),
    speeds too close to each other, or a bend that its uncertainty could undo.
    """
    check_choice("method", method, METHODS)
    data = _Data.of(session)
    least = 3 if method == "naive" else 2
    _check_part(session, "straight", data.slip_m_s[~data.bent], data.speed_sigma_m_s, least)
    across = np.sin(data.lambda_rad[data.bent])
    sigma_m_s = data.speed_sigma_m_s * float(across.max(initial=0.0))
    _check_part(session, "bent", data.slip_m_s[data.bent] * across, sigma_m_s, least)
    _check_bend(session, data)
    return _naive(session, data) if method == "naive" else _joint(session, data)


def friction_points(session: Session, fit: FrictionFit) -> dict[str, tuple[Floats, Floats]]:
    """Return part -> (speeds, forces) of the kept readings, the points of Figs. 15 and 16.

    "straight": v_t and F_t by Eq. 58. "bent": v_n and F_n by Eq. 61, which takes the tangential
    friction as known, here from the fit. m/s and N, whole snake.
    """
    return _points(_Data.of(session), fit.parameters["ct"].value, fit.parameters["ft0"].value)


@dataclass(frozen=True)
class _Data:
    """The kept readings as arrays, with the uncertainties of the instruments."""

    lambda_rad: Floats
    incline_rad: Floats
    slip_m_s: Floats
    bent: NDArray[np.bool_]
    weight_n: float
    incline_sigma_rad: float
    zero_sigma_rad: float
    speed_sigma_m_s: float
    lambda_sigma_rad: float

    @classmethod
    def of(cls, session: Session) -> _Data:
        kept, given = session.kept, session.setup.uncertainty
        lambda_rad = np.array([r.lambda_rad for r in kept])
        return cls(
            lambda_rad=lambda_rad,
            incline_rad=np.array([r.incline_rad for r in kept]),
            slip_m_s=np.array([r.slip_speed_m_s for r in kept]),
            bent=lambda_rad > 0.0,
            weight_n=session.setup.weight_n,
            incline_sigma_rad=given.incline_sigma_rad,
            zero_sigma_rad=given.incline_zero_sigma_rad,
            speed_sigma_m_s=given.belt_speed_sigma_m_s,
            lambda_sigma_rad=given.lambda_sigma_rad,
        )

    def without(self, index: int) -> _Data:
        """Return all readings but one."""
        names = ("lambda_rad", "incline_rad", "slip_m_s", "bent")
        return replace(self, **{name: np.delete(getattr(self, name), index) for name in names})


@dataclass(frozen=True)
class _Raw:
    """What a method found: values, covariance, half-widths of the intervals, in NAMES' order."""

    method: str
    values: Floats
    covariance: Floats
    widths: Floats
    residuals: Floats
    nuisances: dict[str, Estimate]


def _check_part(
    session: Session, part: str, speed_m_s: Floats, sigma_m_s: float, least: int
) -> None:
    bend = "lambda_deg = 0" if part == "straight" else "lambda_deg > 0"
    if len(speed_m_s) < least:
        raise BadInput(
            f"{session.where}: {len(speed_m_s)} {part} reading(s) to use; a fit of all four "
            f"parameters needs at least {least} with {bend}, at different speeds; take more"
        )
    # With less than this between the slowest and the fastest, the noise of the speeds alone could
    # draw the line, and no interval from a linearised fit would be honest.
    spread_m_s = float(np.ptp(speed_m_s))
    if spread_m_s < 4.0 * sigma_m_s:
        raise BadInput(
            f"{session.where}: the {part} readings' speeds along their line span {spread_m_s:.3g} "
            f"m/s; they must span at least four standard deviations, {4.0 * sigma_m_s:.3g} m/s; "
            "add readings at other inclines"
        )


def _check_bend(session: Session, data: _Data) -> None:
    smallest, sigma = (
        np.degrees(x) for x in (data.lambda_rad[data.bent].min(), data.lambda_sigma_rad)
    )
    if smallest <= 3.0 * sigma:
        raise BadInput(
            f"{session.where}: lambda_deg is {smallest:g} with a standard deviation of {sigma:g}; "
            "a bend must be more than three of these from straight; bend further"
        )


def _points(data: _Data, ct: float, ft0: float) -> dict[str, tuple[Floats, Floats]]:
    pull_n = data.weight_n * np.sin(data.incline_rad)
    b, cos, sin = data.bent, np.cos(data.lambda_rad), np.sin(data.lambda_rad)
    along_n = (ct * data.slip_m_s * cos + ft0) * cos
    across_n = (pull_n[b] - along_n[b]) / sin[b]
    return {
        "straight": (data.slip_m_s[~b], pull_n[~b]),
        "bent": (data.slip_m_s[b] * sin[b], across_n),
    }


def _line(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return slope and intercept of the least-squares line, and their rescaled covariance."""
    design = np.column_stack([x, np.ones_like(x)])
    inverse = np.linalg.inv(design.T @ design)
    line = inverse @ design.T @ y
    scatter = y - design @ line
    return line, inverse * (scatter @ scatter) / max(len(x) - 2, 1)


def _two_lines(data: _Data) -> tuple[Floats, Floats]:
    """Return (ct, cn, ft0, fn0) as the paper found them, and their (4, 4) covariance."""
    straight = _points(data, 0.0, 0.0)["straight"]
    (ct, ft0), straight_cov = _line(*straight)
    (cn, fn0), bent_cov = _line(*_points(data, ct, ft0)["bent"])
    covariance = np.zeros((4, 4))
    covariance[0::2, 0::2], covariance[1::2, 1::2] = straight_cov, bent_cov
    return np.array([ct, cn, ft0, fn0]), covariance


def _naive(session: Session, data: _Data) -> FrictionFit:
    from scipy.special import stdtrit

    values, covariance = _two_lines(data)
    freedom = np.array([np.sum(~data.bent), np.sum(data.bent)] * 2) - 2
    widths = stdtrit(freedom, 0.5 + LEVEL / 2) * np.sqrt(np.diag(covariance))
    residuals = _residuals(np.concatenate([values, [0.0, 0.0]]), data)
    return _result(session, data, _Raw("naive", values, covariance, widths, residuals, {}))


def _minimum(session: Session, data: _Data) -> OptimizeResult:
    """Return SciPy's account of the least sum of squares, half of chi2."""
    from scipy.optimize import least_squares

    # The bounds are the physics. A naive value below 0 starts from its mirror image, inside.
    start = np.concatenate([np.abs(_two_lines(data)[0]), [0.0, 0.0]])
    low = np.array([0.0] * 4 + [-np.inf] * 2)
    found = least_squares(
        _residuals,
        start,
        jac=_jacobian,  # pyright: ignore[reportArgumentType]  # SciPy takes functions too
        bounds=(low, np.inf),
        x_scale="jac",
        args=(data,),
        xtol=1e-12,
        ftol=1e-12,
        gtol=1e-12,
    )
    if not found.success:
        raise NotConverged(
            f"{session.where}: the joint fit stopped with {found.message!r} at chi2 = "
            f"{2 * found.cost:.3g}; look for a misread value, or compare with method='naive'"
        )
    return found


def _joint(session: Session, data: _Data) -> FrictionFit:
    from scipy.special import ndtri

    found = _minimum(session, data)
    jacobian = _jacobian(found.x, data)
    covariance = np.linalg.inv(jacobian.T @ jacobian)
    sigmas = np.sqrt(np.diag(covariance))
    # The last two unknowns count in standard deviations of their priors.
    units = np.array([data.lambda_sigma_rad, data.zero_sigma_rad])
    offset, zero = map(Estimate, (units * found.x[4:]).tolist(), (units * sigmas[4:]).tolist())
    raw = _Raw(
        method="joint",
        values=found.x[:4],
        covariance=covariance[:4, :4],
        widths=ndtri(0.5 + LEVEL / 2) * sigmas[:4],
        residuals=found.fun,
        nuisances={"lambda_offset_rad": offset, "incline_zero_rad": zero},
    )
    return _result(session, data, raw)


def _residuals(x: Floats, data: _Data) -> Floats:
    """Return r_i of the readings, then d/sd and z/sz; x is ct, cn, ft0, fn0, d/sd, z/sz."""
    return np.concatenate([_balance(x, data)[0], x[4:]])


def _balance(x: Floats, data: _Data) -> tuple[Floats, ...]:
    """Return r_i, s_i and what the Jacobian needs besides: see the head of this file."""
    ct, cn, ft0, fn0, offset, zero = x
    angle = data.lambda_rad + data.bent * (data.lambda_sigma_rad * offset)
    cos, sin = np.cos(angle), np.sin(angle)
    slope = ct * cos**2 + cn * sin**2
    incline = data.incline_rad - data.zero_sigma_rad * zero
    excess_n = data.weight_n * np.sin(incline) - slope * data.slip_m_s - (ft0 * cos + fn0 * sin)
    per_incline_n = data.weight_n * np.cos(incline)
    spread_n = np.hypot(per_incline_n * data.incline_sigma_rad, slope * data.speed_sigma_m_s)
    return excess_n / spread_n, spread_n, cos, sin, slope, incline, per_incline_n


def _jacobian(x: Floats, data: _Data) -> Floats:
    """Return d r / d x, (readings + 2, 6).

    dr = (d excess - r ds) / s with s ds = A sv^2 dA (+ the incline's part), so that a change of A
    acts at the fitted speed v_i = v_i' + r A sv^2 / s and one of B as it is.
    """
    ct, cn, ft0, fn0, _, _ = x
    r, spread, cos, sin, slope, incline, per_incline = _balance(x, data)
    speed = data.slip_m_s + r * slope * data.speed_sigma_m_s**2 / spread
    turn = data.bent * data.lambda_sigma_rad
    by_offset = turn * (2 * (cn - ct) * sin * cos * speed + fn0 * cos - ft0 * sin)
    spread_by_zero = per_incline * data.incline_sigma_rad**2 * data.weight_n * np.sin(incline)
    by_zero = data.zero_sigma_rad * (per_incline + r * spread_by_zero / spread)
    columns = [cos**2 * speed, sin**2 * speed, cos, sin, by_offset, by_zero]
    return np.vstack([-np.column_stack(columns) / spread[:, None], np.eye(2, 6, 4)])


def _result(session: Session, data: _Data, raw: _Raw) -> FrictionFit:
    if raw.values.min() < 0.0:
        name = NAMES[int(raw.values.argmin())]
        raise BadInput(
            f"{session.where}: the {raw.method} fit gives {name} = {raw.values.min():.3g} "
            f"{UNITS[name]}; it must be at least 0; use method='joint' or look for a misread value"
        )
    covariance = raw.covariance.copy()
    covariance.flags.writeable = False
    values, sigmas = raw.values.tolist(), np.sqrt(np.diag(covariance)).tolist()
    lows = np.maximum(raw.values - raw.widths, 0.0).tolist()
    highs = (raw.values + raw.widths).tolist()
    fit = FrictionFit(
        method=raw.method,
        sigma="rescaled" if raw.method == "naive" else "absolute",
        parameters=MappingProxyType(dict(zip(NAMES, map(Estimate, values, sigmas), strict=True))),
        intervals=MappingProxyType(dict(zip(NAMES, zip(lows, highs, strict=True), strict=True))),
        covariance=covariance,
        ground=Ground.whole_body(session.setup.robot.links, *values),
        chi2=float(raw.residuals @ raw.residuals),
        dof=len(session.kept) - len(NAMES),
        nuisances=MappingProxyType(raw.nuisances),
        residuals=tuple(raw.residuals[: len(session.kept)].tolist()),
        notes=(),
    )
    return replace(fit, notes=(*notes_on(fit, session), *_suspicion(session, data, fit)))


def _suspicion(session: Session, data: _Data, fit: FrictionFit) -> list[str]:
    """Name the reading without which a bad chi2 is least.

    Residuals would mislead, for a line follows its outlier. A part is left with three readings at
    least, or any line would pass.
    """
    if fit.p_value is None or fit.p_value > DOUBTFUL:
        return []
    enough = [k for k in range(len(data.bent)) if np.sum(data.bent == data.bent[k]) > 3]
    left = {k: 2 * _minimum(session, data.without(k)).cost for k in enough}
    if not left:
        return []
    worst = min(left, key=left.__getitem__)
    return [
        f"Without reading {session.kept[worst].number} chi2 would be {left[worst]:.1f}: "
        "look at that one first."
    ]
