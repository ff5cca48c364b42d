"""The marcher of the interface through space and time, for histories and changing strength."""
