"""What knows no snake: the head of the errors, files as text, tables that other programs wrote."""
