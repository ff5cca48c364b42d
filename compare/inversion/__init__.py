"""Fits of measured data: files of gauges, posteriors by emcee, pictures, documents."""

from compare.inversion.data import read_gauges
from compare.inversion.posterior import Posterior, posterior

__all__ = ["Posterior", "posterior", "read_gauges"]
