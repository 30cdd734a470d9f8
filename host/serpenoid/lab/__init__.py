"""A world to practise and test in: a robot on a belt or a floor, instruments, and a person."""
