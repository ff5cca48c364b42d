"""Tuning constants of the engine, each with the measurement that set it."""

from __future__ import annotations

STEP_RATIO = 0.4
"""Shortest step c_t dt / h; with 0.5 slip rates of pulses are 10 to 15 % less exact."""
LADDER = 2.0
"""Ratio of two rungs: with sqrt(2) errors are the same, and twice as many tables are kept."""
BOUND_SHARE = 0.7
"""Share of the longest step at which the iteration of a step still converges."""
LARGEST_HORIZON = 1e6
"""Largest q c_t t of a fit: from 1e8 on its values at short times are off by 1e-3."""
NODES = 512
MOST_NODES = 16384
ZONE_NODES = 3.0
"""Nodes on mu / (fall of strength per slip) from which on a rupture is resolved."""
BESIDE_EDGE_ERROR = 0.3
"""Error of a singular traction next to an edge; with half pressure is off by 1.2 estimates."""
FILM_EDGE_ERROR = 0.45
"""Error of slip next to an edge under a stiff film, over that of the first node: 0.35 in closed
form, 0.48 on 7 nodes."""
LEAST_GAP = 0.01
"""Part of slip below which gaps decide nothing: next to slots nodes open by 2e-4."""
LEAST_ZONE = 0.1
"""Part of the largest slip zone below which the error of another one does not count by itself."""
