"""The fit's mathematics: readings as arrays, identifiability, joint, naive, influence."""
