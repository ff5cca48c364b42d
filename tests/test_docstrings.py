"""Docstrings of public names: they read as sentences, and their examples run."""

import doctest
import inspect
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

import fem
import semianalytic
from semianalytic.dissimilar_slot import solver

DESCRIBED = {
    f"{module.__name__}.{name}": getattr(module, name)
    for module in (semianalytic, fem)
    for name in module.__all__
    if inspect.isclass(getattr(module, name)) or inspect.isfunction(getattr(module, name))
}
LONGEST = "PairDerivative"
"""Its example takes more than half of the time of all that the default run takes."""
METHODS = {
    f"{method.__module__}.{method.__qualname__}": method
    for member in DESCRIBED.values()
    if inspect.isclass(member)
    for base in member.__mro__
    for method in map(inspect.unwrap, (getattr(m, "__func__", m) for m in vars(base).values()))
    if inspect.isfunction(method) and method.__module__.startswith(("semianalytic.", "fem."))
}
WITH_EXAMPLES = [
    name for name, member in (DESCRIBED | METHODS).items() if ">>>" in (member.__doc__ or "")
]

ROOT = Path(__file__).parents[1]
CITED = re.compile(r'docs/(\w+)\.md, "([^"]+)"')
"""A section of a page, as docstrings and comments cite it."""


def cited_sections() -> Iterator[tuple[str, str, str]]:
    """Yield file, page and section of each citation in docstrings and comments."""
    for folder in ("semianalytic", "fem", "meshes"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            text = re.sub(r"\n\s*(# )?", " ", path.read_text(encoding="utf-8"))
            for page, section in CITED.findall(text):
                yield str(path.relative_to(ROOT)), page, section


def first_sentence(docstring: str) -> str:
    """Return the first paragraph of a docstring on one line."""
    return " ".join(inspect.cleandoc(docstring).split("\n\n")[0].split())


def test_docstrings_begin_with_a_sentence() -> None:
    begun = {name: first_sentence(member.__doc__) for name, member in DESCRIBED.items()}
    assert len(begun) > 50
    assert {name: item for name, item in begun.items() if not re.match(r"[A-Z].*\.$", item)} == {}


def test_described_parameters_are_those_of_the_signature() -> None:
    # Text that follows a section without a heading of its own would be read as a parameter.
    unknown = {}
    for name, member in (DESCRIBED | METHODS).items():
        text = inspect.cleandoc(member.__doc__ or "")
        if section := re.search(r"(?ms)^Parameters\n-+\n(.*?)(?=^[^\n]+\n---+$|\Z)", text):
            lines = re.findall(r"(?m)^\S.*$", section[1])
            words = {word.strip("* ") for line in lines for word in line.split(":")[0].split(",")}
            if words - set(inspect.signature(member).parameters):
                unknown[name] = lines
    assert unknown == {}


def test_public_names_have_examples() -> None:
    errors = {
        name
        for name, member in DESCRIBED.items()
        if inspect.isclass(member) and issubclass(member, Exception)
    }
    assert set(DESCRIBED) - set(WITH_EXAMPLES) - errors == set()


@pytest.fixture(autouse=True, scope="module")
def pairs_solved_once() -> Iterator[None]:
    """Several examples solve the same pair."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(solver, "coupled", cache(solver.coupled))
        yield


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    "name",
    [pytest.param(entry, marks=[pytest.mark.slow] * (entry == LONGEST)) for entry in WITH_EXAMPLES],
)
def test_examples_run(name: str) -> None:
    described = (DESCRIBED | METHODS)[name]
    (test,) = doctest.DocTestFinder(recurse=False).find(
        described, name, module=inspect.getmodule(described), globs={}
    )
    said: list[str] = []
    failed = doctest.DocTestRunner(verbose=False).run(test, out=said.append).failed
    assert not failed, "".join(said)


def test_cited_sections_exist() -> None:
    cited = set(cited_sections())
    headings = {
        page: re.findall(
            r"^(?:#+ |\*\*)(.+?)(?:\.?\*\*.*)?$",
            (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8"),
            flags=re.MULTILINE,
        )
        for _, page, _ in cited
    }
    assert len(cited) > 5
    assert {page for page in cited if page[2] not in headings[page[1]]} == set()
