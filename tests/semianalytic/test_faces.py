"""What others verify against is named, explained and importable in one place."""

import importlib
import inspect

import pytest


@pytest.mark.parametrize("face", ["semianalytic.reference", "semianalytic.regimes"])
def test_every_public_name_is_documented_and_in_the_overview(face):
    module = importlib.import_module(face)
    functions = {name for name, thing in vars(module).items() if inspect.isfunction(thing)}
    assert functions <= set(module.__all__)
    for name in module.__all__:
        assert f"`{name}`" in module.__doc__ or inspect.isclass(getattr(module, name)), name
    for name in functions:
        assert getattr(module, name).__doc__, name
