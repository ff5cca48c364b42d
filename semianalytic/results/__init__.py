"""Results: what all answers have in common, their samples and files, and the memory they need."""
