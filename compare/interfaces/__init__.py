"""Interfaces by both methods: run, simulated with finite elements, and judged."""

from compare.interfaces.judging import InterfaceJudgement, compare_interface

__all__ = ["InterfaceJudgement", "compare_interface"]
