"""Fits of measured data: files of gauges, pictures, documents."""

from slipfront.fits.data import read_gauges

__all__ = ["read_gauges"]
