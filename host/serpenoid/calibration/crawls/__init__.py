"""Crawls in the friction fit: their speeds beside pushes and stations, or alone, by draws."""
