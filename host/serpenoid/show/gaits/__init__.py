"""What is drawn and said of gaits: optima, losses of speed, the remade study."""
