"""What is drawn and said of gaits: optima, margins, cliffs, the remade study."""
