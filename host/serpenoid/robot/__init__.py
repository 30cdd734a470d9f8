"""The host's end of the wire to the board; see firmware/PROTOCOL.md."""
