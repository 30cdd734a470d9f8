"""From corners to the robot: camera, tag mountings, and the chain of links."""
