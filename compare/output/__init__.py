"""Output of results: complete files, checks of output paths, removal of outdated files."""
