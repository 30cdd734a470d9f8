"""Bad input is refused in words that say what is wrong."""

from __future__ import annotations

import pytest
from serpenoid import BadInput


def refused(words: str) -> pytest.RaisesExc[BadInput]:
    """Expect a refusal whose message has these words, a regular expression."""
    return pytest.raises(BadInput, match=words)
