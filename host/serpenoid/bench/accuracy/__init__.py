"""Error against run time of every method, beside SciPy's."""
