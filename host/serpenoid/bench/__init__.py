"""Benchmarks: error against run time, stability, and what a scene costs; SciPy is the one peer."""
