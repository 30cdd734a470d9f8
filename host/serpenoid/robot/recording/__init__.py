"""A run on disk: written line by line as it happens, and read back into arrays."""
