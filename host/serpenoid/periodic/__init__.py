"""Cycles that repeat, solved for and not waited for: the periodic state of one gait or many."""
