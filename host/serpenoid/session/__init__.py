"""What was measured: the settings of a session, its readings, and its files."""
