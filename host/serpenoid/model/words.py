"""The words that a scene is told in."""

FORMULATIONS = ("explicit", "implicit")
DRIVES = ("angle", "torque", "servo")
LAWS = ("viscous", "smoothed", "dry")
STARTS = ("link1_at_rest", "zero_momentum", "steady")
GAPS = ("slow_manifold", "zero")
RECORDS = ("joints", "friction", "energy")
