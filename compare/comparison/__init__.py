"""Comparison of predictions with simulations: measures, rows, verdicts and the report."""
