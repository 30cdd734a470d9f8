"""The command line: degrees outside, SI inside. It asks, calls and shows."""
