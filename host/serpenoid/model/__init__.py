"""What a study is made of: robot, ground, gait, link states, drives."""
