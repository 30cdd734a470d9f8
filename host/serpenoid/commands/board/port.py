"""The option that names the port."""

from __future__ import annotations

from ..declare import option

PORT = option(
    "--port",
    "Serial port; found by its USB id unless given. `virtual` or `virtual:joints=9` needs no "
    "robot.",
)
