"""Marches and errors that tests of the space-time solver share."""

from functools import partial

import numpy as np
from catalogue import unit_scene

import semianalytic as sf

march = partial(sf.solve, method="space-time")


def preloaded(friction=0.3, shear=1.0, **parts):
    return unit_scene(friction, load=(0.0, shear), **parts)


def relative_l1(found, wanted):
    return np.abs(found - wanted).sum() / np.abs(wanted).sum()
