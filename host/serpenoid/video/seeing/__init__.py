"""From a file to the corners of tags: decoding, searching, edges, the floor."""
