"""The singular equations of a slot between two bodies for given zones, and the fields they give."""
