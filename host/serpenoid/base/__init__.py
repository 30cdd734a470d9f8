"""What every room uses and that knows no snake: errors, checks, files, tables, the system."""
