"""Slip on a frictional interface after a sudden load: exact where self-similar, else marched.

A module is imported when one of its public names is first used.
"""

import logging

from semianalytic.names import attached

logging.getLogger(__name__).addHandler(logging.NullHandler())  # silent unless asked

__all__, __getattr__ = attached(__name__)


def __dir__() -> list[str]:
    return __all__
