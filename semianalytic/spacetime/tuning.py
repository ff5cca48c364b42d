"""Tuning constants of the space-time solver, each with the measurement that set it.

Measurements are those of docs/spacetime.md unless stated otherwise.
"""

from __future__ import annotations

# --- the march --------------------------------------------------------------------------------

NODES = 1000
"""Default number of observed nodes: the slip rate of `preloaded` is off by 0.007 % in 0.3 s."""
LEAST_NODES = 16
MOST_NODES = 8000
"""Largest number of nodes that a march chooses by itself, some 20 seconds of work."""
LARGEST_STEP_RATIO = 2.0
"""Largest c_t dt / h that is tried; the feedback refuses 0.5 to 0.7 or more, by Poisson ratio."""
DAMPING = 0.7
"""Default least feedback of the shortest wave: without any, small steps leave an odd-even mode."""
TOLERANCE = 1e-6
"""Default tolerance of the memory's transform: for 1024 nodes as good as 1e-10."""
BLOCK_STEPS = 64
"""Largest number of steps that are recorded at once: 16 take 1.2 times as long, 256 as long (256
nodes)."""
STEP_VALUES = 1 << 15
"""Slip rates in a block of steps, so that its five fields stay in the cache: with half of it a
march takes 1.1 times as long, with twice as many no longer (1,024 nodes)."""
AVERAGED_BREAKS = 2
"""Number of breaks of a load within a step from which on a level takes the mean: values at the
levels represent one kink, but not several."""
TOLERANCES = (1e-11, 1e-2)
"""Range of the tolerance of the memory's transform: 1e-11 takes 45 poles; 1e-2 is coarser than the
grid."""

# --- the error of a march ----------------------------------------------------------------------

ERROR_SAFETY = 1.25
"""Estimate of the L1 error of the slip rate over the difference from the companion at half the
nodes: the true error is 0.35 to 1.05 of that difference in 100 scenes (`march-error`), whatever the
loads."""
ORDER_SAFETY = 1.3
"""The same times 2^p - 1, where an order p was seen between two marches.  In the marches of 1,000
nodes of 50 scenes, with orders from 250 nodes on, estimates were 1.25 to 4.2 times the true errors,
1.7 times in the median; with 1.0 the least is 0.97, and with 2.6 orders above 1.6 alone would gain
anything."""
HIGHEST_ORDER = 1.6
"""Order beyond which one that was seen is not believed: with 1.8 an estimate may be half of the
difference, which true errors are at orders of 1.3 to 1.6; without, `ERROR_SAFETY` alone is left."""
LARGEST_ERROR = 0.5
"""Estimate above which a march is called unresolved unless an `rtol` is given: away from the edge,
strips of slip narrower than the grid have no other sign.  The true errors of 420 random marches on
24 to 160 nodes, 284 of them in antiplane shear, were at most 0.86 of their estimates; in one march
with an estimate of 0.75 almost all of the slip rate was wrong.  A limit of 1 lets that march pass;
a limit of 0.3 refuses one march in forty more, most of them with errors below 0.15."""
READING_SAFETY = 1.6
"""Estimate of the error of any other reading over the difference from the companion: the largest
slip, which is at the edge, converges more slowly, and single numbers less evenly; their true errors
are 0.1 to 1.7 of the difference."""
MEMORY_SAFETY = 4.0
"""Factor on the error of the memory's transform, which march and companion share: at a tolerance of
1e-4 the slip rate is off by 3.5 times that."""
FIRST_NODES = 250
"""Nodes of the first march for an `rtol`: 0.6 % in 0.05 s (`preloaded`)."""
LARGEST_GROWTH = 4.0
"""Largest growth of the nodes from one march for an `rtol` to the next: the order is not known
before the second, and a march at a quarter of the nodes costs a sixteenth."""
LEAST_GROWTH = 1.3
GROWTH_MARGIN = 1.15
"""Factor by which the error aimed at lies below `rtol`."""
ORDERS = (0.5, 2.0)
"""Range within which the order seen in two marches is believed; 0.7 to 1.4 are measured."""

# --- the memory of the machine ----------------------------------------------------------------

LEAST_LEVELS = 16
"""Least number of levels that must fit into the memory."""
TYPICAL_POLES = 25
"""Number of poles assumed before the fit gives it: 15 to 40."""
BYTES_PER_POLE = 128
"""Bytes per pole and node of the grid at the peak of a march: eight complex arrays, measured."""
BYTES_PER_NODE = 400
"""Further bytes per node of the grid, measured."""
BYTES_STORED = 32
"""Bytes per observed node and stored level: four fields."""
BYTES_PER_STEP = 96
"""Bytes per step for times, loads and totals."""
