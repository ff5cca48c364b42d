"""The memory of an interface for its past slip: impedance, sum of exponentials, recursion."""
