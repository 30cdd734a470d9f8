"""Benchmarks: error against run time, stability, and what a scene costs; peers are optional."""
