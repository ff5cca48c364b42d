"""Thousands of random scenes held against the laws every answer must keep."""
