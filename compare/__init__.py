"""Comparison of solvers, records of other codes, validation, benchmarks, figures and studies.

`judge` compares any prediction with a simulation; docs/judge.md states how reliable its verdicts
are.  `choose_mesh` predicts which mesh a comparison needs.
"""

import logging

from semianalytic.names import attached

logging.getLogger(__name__).addHandler(logging.NullHandler())  # silent unless asked

__all__, __getattr__ = attached(__name__)
