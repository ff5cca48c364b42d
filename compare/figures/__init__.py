"""Figures of solutions, marches, simulations and their comparison."""
