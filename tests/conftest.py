"""What all tests share."""

import pytest


@pytest.fixture(autouse=True, scope="session")
def mesh_cache(tmp_path_factory):
    """Meshes are built anew by every test run, and once for all tests."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SLIPFRONT_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield
