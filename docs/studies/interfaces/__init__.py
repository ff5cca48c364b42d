"""Interfaces against finite elements: the named ones, and random pairs of bodies."""
