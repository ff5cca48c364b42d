"""Comparisons of the engine with codes that others wrote, which are no part of this package."""
