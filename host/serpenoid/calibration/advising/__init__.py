"""What to measure next, where it is not on a treadmill."""
