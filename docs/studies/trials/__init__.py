"""Random scenes: what the methods say of them, and what the judges of comparisons say."""
