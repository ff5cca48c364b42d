"""Scenes: bodies, tractions, load histories and friction laws, how they are read and checked."""
