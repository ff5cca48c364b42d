"""Surveys: one scene at many values of its parameters, on many processes or machines."""

from slipfront.surveys.run import survey

__all__ = ["survey"]
