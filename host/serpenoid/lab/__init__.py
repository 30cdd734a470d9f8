"""A world for the demo and tests: a robot on a belt or a floor, instruments, and a person."""
