"""Servos that people buy or have measured, by name or from a file."""
