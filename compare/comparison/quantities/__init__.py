"""Quantities of a comparison: fronts, edges, profiles, histories and single places."""
