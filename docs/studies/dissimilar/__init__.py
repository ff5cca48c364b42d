"""Friction between different bodies: where waves grow, and what exact answers are worth."""
