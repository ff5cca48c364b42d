"""What tests of the page share."""

import pytest

from slipfront.explore.jobs import Worker


@pytest.fixture
def alone(monkeypatch):
    """Sessions start no process beside them; what they would start is kept."""
    started = []
    monkeypatch.setattr(Worker, "start", lambda _, *job: started.append(job))
    return started
