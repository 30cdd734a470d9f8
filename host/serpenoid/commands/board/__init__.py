"""The commands that deal with a board: ports, doctor, flash, drive, trim, monitor."""
