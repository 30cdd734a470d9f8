"""Taking a session: what comes next, and a person, a robot or a script that does it."""
