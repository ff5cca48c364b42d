"""Scenes on the command line: their list, a file to start from, and completion of names."""
