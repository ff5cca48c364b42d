"""Tuning constants of the memory of the interface, each with the measurement that set it.

Measurements are those of docs/spacetime.md.
"""

from __future__ import annotations

# --- the fit of exponentials ---------------------------------------------------------------------

SAMPLES = 60
"""Points of the transform on each of five stretches; the fit is checked on four times as many."""
MOST_PAIRS = 60
"""Largest number of pairs of conjugate poles; the finest tolerance takes 45 poles."""
FAR_SAMPLE = 30.0
"""Largest s of samples: 1.5/s^2, the tail of G - 1, is right to 0.1 % there (nu = 1/3)."""
SHORTEST_SAMPLE = 0.1
"""Smallest distance of samples to the branch points, over 1 / horizon."""
LEAST_KERNEL = 1e-3
"""Least size of one of several kernels, over that of the largest, to which its error is relative:
smaller ones do not matter to the march, and rounding of 1e-11 of the largest hides them."""

# --- the memory of a line ------------------------------------------------------------------------

MEMORY_STEPS = 4
"""Steps after which a large memory is brought up to date: with 2 it takes 1.5 times as long, with 8
three quarters (400 grid nodes; from 1,600 on the three differ by a fifth).  Each step needs 16
bytes per pole and node."""
MEMORY_SIZE = 20_000
"""Poles times wavenumbers from which on a memory is large, 320 kB of numbers.  On 1,000 nodes a
march takes 1.2 times as long without; a memory of 12,000 numbers takes as long either way."""
REPEATED_STEPS = 2
"""Steps of equal length after which more of them are expected."""
