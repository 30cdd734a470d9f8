"""Error against run time of every method, beside its peers."""
