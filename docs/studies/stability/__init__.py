"""Stability studies: where the methods fail, how, and how the program reacts."""
