"""A session on a floor: its steps, tracks taken in, and a person who does it in the lab."""
