"""Fits of measured data: files of gauges, posteriors by emcee, pictures, documents."""

from slipfront.fits.data import read_gauges
from slipfront.fits.posterior import Posterior, posterior

__all__ = ["Posterior", "posterior", "read_gauges"]
