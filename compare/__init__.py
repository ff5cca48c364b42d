"""Comparison of solvers, records of other codes, validation, benchmarks, figures and studies.

`judge` compares any prediction with a simulation; docs/judge.md states how reliable its verdicts
are.  `choose_mesh` predicts which mesh a comparison needs.
"""

import logging
from importlib import import_module
from typing import TYPE_CHECKING, Any

logging.getLogger(__name__).addHandler(logging.NullHandler())  # silent unless asked

__all__ = ["Judgement", "MeshChoice", "Row", "Unseen", "choose_mesh", "judge"]

_PLACES = {
    **dict.fromkeys(("Judgement", "judge"), "compare.comparison.judgement"),
    **dict.fromkeys(("MeshChoice", "Unseen", "choose_mesh"), "compare.comparison.mesh_choice"),
    "Row": "compare.comparison.rows",
}

if TYPE_CHECKING:  # which would let a misspelt name pass behind __getattr__
    from compare.comparison.judgement import Judgement, judge
    from compare.comparison.mesh_choice import MeshChoice, Unseen, choose_mesh
    from compare.comparison.rows import Row
else:

    def __getattr__(name: str) -> Any:
        """A name of a module that is not imported yet."""
        if name not in _PLACES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        globals()[name] = getattr(import_module(_PLACES[name]), name)
        return globals()[name]
