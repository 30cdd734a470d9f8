"""Whether the readings of a session agree with one another, in words."""

from __future__ import annotations

from ...friction.result import DOUBTFUL, FrictionFit


def agreement(fit: FrictionFit) -> str:
    """Return in words whether the readings agree, and which one to look at if they do not."""
    if fit.p_value is None:
        return "no reading too many: nothing checks the fit yet"
    chi2 = f"χ² {fit.chi2:.1f} for {fit.dof} degrees of freedom"
    if fit.p_value >= DOUBTFUL:
        return f"{chi2}: the readings agree"
    alarm_of_chi2 = next((alarm for alarm in fit.alarms if alarm.startswith("chi2 is")), "")
    return f"{chi2}: THE READINGS DISAGREE. {alarm_of_chi2.partition('intervals. ')[2]}".rstrip()
