"""The command line: degrees outside, SI inside; asks, calls and shows, without a thought."""
