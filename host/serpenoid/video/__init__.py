"""A film of the robot as an instrument: tags on its links to speed, path and every joint's sine."""
