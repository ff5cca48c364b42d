"""Panels of slowness between edges and wave fronts, and integrals along them."""
