"""`python -m serpenoid` is the command `serpenoid`."""

from .commands.main import main

main()
