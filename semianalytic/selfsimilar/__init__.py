"""The exact solver of self-similar scenes: a first guess on a grid, then zones, edges, Coulomb."""
