"""Taking a session: what to do next, by whom, and every reading on disk before the next one."""
