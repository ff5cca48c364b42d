"""Surveys: one scene at many values of its parameters, on many processes or machines."""
