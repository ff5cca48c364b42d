"""Error against computing time of every method, for any scene."""
