"""The elastic half-plane: Rayleigh function, tractions of a stuck interface, kernels, rules."""
