"""Friction laws: the strength of an interface by pressure, slip rate and state."""
