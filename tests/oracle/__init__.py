"""Slow, obvious, independent truth that the compiled core is held to (shares no code with it)."""
