"""The stepping of an interface: nodes, memory, the local problem, and steps of any length."""
