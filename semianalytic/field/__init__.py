"""Whole fields: what the tractions of the interface send into the bodies, exactly."""
