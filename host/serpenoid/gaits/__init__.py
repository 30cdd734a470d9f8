"""Which gait to take: least power for a speed, and how much it forgives."""
