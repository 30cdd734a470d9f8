"""A file's hash, read in blocks: films are large."""

from __future__ import annotations

import hashlib
from pathlib import Path

BLOCK_BYTES = 1 << 20


def sha256_of(path: Path) -> str:
    """Return a file's SHA-256, in hexadecimal digits."""
    done = hashlib.sha256()
    with path.open("rb") as file:
        while block := file.read(BLOCK_BYTES):
            done.update(block)
    return done.hexdigest()
