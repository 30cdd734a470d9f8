"""The fit's mathematics: readings as arrays, gate, joint, naive, robust, influence."""
