"""The study of 2005, remade with this package."""
