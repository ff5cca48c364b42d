"""On top of the solvers: command line, judgement, figures, studies.

`judge` holds any prediction against a simulation; see docs/judge.md for how far it can be trusted.
`choose_mesh` says beforehand which mesh is worth it.
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
