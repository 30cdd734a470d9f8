"""Commands that end in friction or begin with it: fit, compare, advise, report."""
