"""Whole fields: the exact fields in the bodies that the tractions of the interface cause."""
