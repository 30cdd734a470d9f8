"""From the treadmill to friction, and from friction to a speed that can be compared."""
