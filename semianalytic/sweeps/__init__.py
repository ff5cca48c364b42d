"""Sweeps: many self-similar scenes that differ in friction or Poisson ratio, solved together."""
