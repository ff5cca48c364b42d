"""Docstrings of public names: they read as sentences, and their examples run."""

import doctest
import inspect

import pytest

import fem
import semianalytic

WRITTEN_ELSEWHERE = ("semianalytic.selfsimilar", "semianalytic.cut")
"""Packages whose docstrings need not have examples yet."""
DESCRIBED = {
    f"{module.__name__}.{name}": getattr(module, name)
    for module in (semianalytic, fem)
    for name in module.__all__
    if inspect.isclass(getattr(module, name)) or inspect.isfunction(getattr(module, name))
}
WITH_EXAMPLES = [name for name, one in DESCRIBED.items() if ">>>" in (one.__doc__ or "")]


def first_sentence(docstring: str) -> str:
    """Return the first paragraph of a docstring on one line."""
    return " ".join(inspect.cleandoc(docstring).split("\n\n")[0].split())


@pytest.mark.parametrize("name", DESCRIBED)
def test_docstring_begins_with_a_sentence(name: str) -> None:
    sentence = first_sentence(DESCRIBED[name].__doc__)
    assert sentence[0].isupper(), sentence
    assert sentence.endswith("."), sentence


@pytest.mark.parametrize("name", DESCRIBED)
def test_public_names_have_examples(name: str) -> None:
    described = DESCRIBED[name]
    is_error = inspect.isclass(described) and issubclass(described, Exception)
    if not is_error and not described.__module__.startswith(WRITTEN_ELSEWHERE):
        assert name in WITH_EXAMPLES


@pytest.mark.parametrize("name", WITH_EXAMPLES)
def test_examples_run(name: str) -> None:
    described = DESCRIBED[name]
    (test,) = doctest.DocTestFinder(recurse=False).find(
        described, name, module=inspect.getmodule(described), globs={}
    )
    said: list[str] = []
    failed = doctest.DocTestRunner(verbose=False).run(test, out=said.append).failed
    assert not failed, "".join(said)
