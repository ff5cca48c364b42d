"""On top of the solvers: command line, judgement, figures, studies.

`judge` holds any prediction against a simulation; see docs/judge.md for how far it can be trusted.
"""

from compare.comparison.judgement import Judgement, judge
from compare.comparison.rows import Row

__all__ = ["Judgement", "Row", "judge"]
