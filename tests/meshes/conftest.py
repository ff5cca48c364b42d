"""Where meshes are cached in tests of them."""

import pytest


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    """No mesh is there yet."""
    monkeypatch.setenv("SLIPFRONT_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"
