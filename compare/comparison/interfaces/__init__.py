"""Interfaces by both methods: run, simulated with finite elements on three meshes, and judged."""

from compare.comparison.interfaces.comparing import compare_interface

__all__ = ["compare_interface"]
