"""What the demo shows: a session on a treadmill, pushes along a floor, a film."""
