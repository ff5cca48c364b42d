"""What answers have in common, and what they are kept in: samples, files, memory asked for."""
