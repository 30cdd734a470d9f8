"""Commands about gaits: one, a grid, the best, and the study of 2005."""
