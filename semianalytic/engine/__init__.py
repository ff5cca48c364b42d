"""The march of an interface: memory of the line, contact that opens, steps of any length."""
