"""How honest a calibration is: coverage of its intervals, and what advice saves."""
