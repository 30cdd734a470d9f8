"""Benchmarks: error against run time beside SciPy, stability, and what each term costs."""
