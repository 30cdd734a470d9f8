"""For users of other tools: a robot as MuJoCo's XML, the simulator as a Gymnasium environment."""
