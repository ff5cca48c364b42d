"""Comparison of the field snapshots of a simulation with the exact fields in both bodies."""
