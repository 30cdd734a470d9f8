"""PlatformIO's runner plug-in has a test's name but is none."""

collect_ignore = ["test_custom_runner.py"]
