"""On top of the solvers: command line, judgement, figures, studies.

`judge` holds any prediction against a simulation; see docs/judge.md for how far it can be trusted.
`choose_mesh` says beforehand which mesh is worth it.
"""

from compare.comparison.judgement import Judgement, judge
from compare.comparison.mesh_choice import MeshChoice, Unseen, choose_mesh
from compare.comparison.rows import Row

__all__ = ["Judgement", "MeshChoice", "Row", "Unseen", "choose_mesh", "judge"]
