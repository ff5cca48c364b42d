"""Interfaces as files, names and numbers: what surveys and fits vary."""
