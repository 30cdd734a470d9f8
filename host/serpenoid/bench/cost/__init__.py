"""What runs cost: instructions by scene, time by links, ratios against hand-written kernels."""
