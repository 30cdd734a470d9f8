"""Robots that roll out on a floor or slide down a board: the law, the fit, tracks, their checks."""
