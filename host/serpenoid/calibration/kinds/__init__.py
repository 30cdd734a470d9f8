"""Kinds of readings, each declared once: columns, units, limits, prompts, and its dataclass."""
