"""Finite-element simulation of a loaded slot: scikit-fem blocks, contact without a penalty."""

import logging

from semianalytic.names import attached
from semianalytic.scene.extras import FEM, require

logging.getLogger(__name__).addHandler(logging.NullHandler())  # silent unless asked

require("the finite-element model", *FEM)
__all__, __getattr__ = attached(__name__)


def __dir__() -> list[str]:
    return __all__
