"""Every Python program of README and of the pages runs as it is pasted, in a folder of its own,
and prints what stands below it."""

import contextlib
import io
import logging
import re

import pytest
from matplotlib import pyplot

from docs.studies.pages import ROOT, pages

SNIPPETS = {
    f"{page.name}-{number}": code
    for page in pages()
    for number, code in enumerate(
        re.findall(
            r"```python\n(.*?)```(?:\n\n(?:(?:It )?prints\n\n)?```text\n(.*?)```)?",
            page.read_text(encoding="utf-8"),
            re.DOTALL,
        )
    )
}
LONG = ("extending.md-1", "start.md-2", "survey.md-0", "spacetime.md-0")
"""Programs that take more than three seconds."""


@pytest.mark.parametrize(
    "name", [pytest.param(entry, marks=[pytest.mark.slow] * (entry in LONG)) for entry in SNIPPETS]
)
def test_snippet_runs_as_pasted(name, tmp_path, monkeypatch):
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    monkeypatch.chdir(tmp_path)
    code, printed = SNIPPETS[name]
    with contextlib.redirect_stdout(io.StringIO()) as shown:
        exec(compile(code, name, "exec"), {"__name__": "pasted"})
    assert shown.getvalue() == (printed or shown.getvalue())
    pyplot.close("all")
    logging.getLogger("semianalytic").setLevel(logging.NOTSET)  # one program sets it
