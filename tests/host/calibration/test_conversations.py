"""People at the prompt, word for word: what they type, and all that is said to them."""

import pytest

from .conversations import FILES, played


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_it_is_said_as_it_is_written_down(file) -> None:
    assert played(file) == file.read_text()
