"""Scenes on the command line: a list of them, a file to start from, names as they are typed."""
