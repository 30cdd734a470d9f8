"""Tables and figures: matplotlib and rich live here alone."""
