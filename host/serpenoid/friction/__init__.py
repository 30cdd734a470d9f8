"""From a session to friction of the whole snake, with intervals."""
