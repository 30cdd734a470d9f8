"""A person at the treadmill: what is asked and typed, the robot, the page to look at."""
