"""A person at the treadmill: what is asked and typed, and the robot."""
