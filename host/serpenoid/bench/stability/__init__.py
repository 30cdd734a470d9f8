"""Which steps are stable, and what extreme scenes do to every method."""
