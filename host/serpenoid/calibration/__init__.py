"""From readings on a treadmill or a floor to friction, with honest intervals."""
