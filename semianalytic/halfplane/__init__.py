"""What an elastic half-plane does: Rayleigh function, tractions while stuck, kernels, rules."""
