"""Interfaces to be marched: where bodies touch, friction, fields along x, loads, files, names."""
