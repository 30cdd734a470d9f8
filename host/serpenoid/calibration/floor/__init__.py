"""Robots that roll out on a floor: the law, the fit, tracks, their checks."""
