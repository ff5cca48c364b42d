"""Many self-similar scenes that differ in friction, in one go."""
