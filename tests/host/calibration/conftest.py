"""A new session, as tests of the folder take it unless they make one of their own."""

import pytest
from serpenoid.taking.new_session import create_session, default_setup


@pytest.fixture
def folder(tmp_path):
    return create_session(tmp_path / "session", default_setup("made up"))
