"""What all tests share: the fixtures of the simulated board."""

pytest_plugins = ["avr.fixtures"]
