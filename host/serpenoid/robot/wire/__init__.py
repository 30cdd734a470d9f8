"""Bytes to messages and back: the port, the protocol, recordings, the clock."""
