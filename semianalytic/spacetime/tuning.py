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
MARGIN_NODES = 8
"""Nodes beyond the reach of waves on either side.  Without any, 6e-4 of the largest slip rate comes
back from the mirrors (`remote-shock`, 400 nodes); from two on nothing changes."""
LARGEST_STEP_RATIO = 2.0
"""Largest c_t dt / h that is tried; the feedback refuses 0.5 to 0.7 or more, by Poisson ratio."""
SWEEPS = 2
"""Iterations of a step, an even number: with one or three, marches grow without bounds.  With two
and four the slip rate is off by 0.038 and 0.040 % (`preloaded`), 0.192 and 0.196 %
(`remote-shock`), 0.433 and 0.432 % (`auxetic`), 400 nodes."""
AREA = 1.5
"""Stretch of the line over which a node takes the mean of what slips, in node distances.  With 0,
1.5 and 2 the slip rate of `antiplane` is off by 2.6e-4, 0.9e-4 and 0.3e-4 (1,024 nodes), and that
of a zone a thirteenth of the contact long by 4.0, 1.8 and 3.0 % (256 nodes)."""
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
WEAKENING_NODES = 8.0
"""Nodes in the process zone of slip weakening from which on slip and frictional work are right to
1 %: off by 0.6 and 0.6 % with 8, 0.9 and 1.0 % with 6, in the worst of three scenes."""
LEAST_WEAKENING_NODES = 2.0
"""Nodes in the process zone below which the grid, not the law, sets its length: slip is off by 4 %,
its rate by 22 %."""
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

# --- what a grid follows ----------------------------------------------------------------------

LARGEST_TURN = {1: 0.08, 4: 0.32}
"""Largest turn of a load within so many steps h / (2 c_t), over its largest value: frictional work
is then off by 1 to 3 %."""
STEP_RATIO = 0.5
"""Ratio c_t dt / h of those steps; smaller ones do not help."""
ZONE_NODES = 5.0
"""Nodes from which on a slip zone at the edge counts as resolved: frictional work is 1.3 to 1.9 %
off at Poisson ratios of 0.1 to 0.45 and frictions of 3 to 40, and the estimate of the error, 0.36
to 0.38, stays below `LARGEST_ERROR`.  With 4 nodes the estimate is 0.49 to 0.51, so that the
default march of every narrow zone would be on the border; 8 nodes halve the error of the work."""
HALVINGS = 50
"""Most bisections for the step that follows a load; they end at 0.1 %."""
TIMES = 2000
"""Number of times at which the slip zone at the edge is looked at, fewer if a load has many
breaks."""
LEAST_TIMES = 40
MOST_SAMPLES = 4 * 10**6
"""Largest product of times and breaks, so that tables of thousands of samples do not delay a
march."""
NO_INTENSITY = 1e-9
"""Relative excess of the stress intensity over friction that counts as rounding."""

# --- the pressure on the grid -----------------------------------------------------------------

EXACT_KINKS = 4
"""Largest number of kinks that are treated exactly at every level: 4 take 2.6 s and 8 take 6.4 s
for 1,500 nodes and 1,000 levels, a table of any number 3 s."""
TABLE_SAMPLES = 2
"""Samples of the table per time step, so that a kink is spread over half a step."""
TABLE_ROWS = 64
"""Nodes whose responses are convolved at once, to stay in the cache."""
BLOCK_VALUES = 1 << 16
"""Pressures that are computed at once, to stay in the cache."""

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
TABLE_BYTES = 8
"""Bytes per sample of the pressure table."""

# --- fields in the bodies -----------------------------------------------------------------------

FIELD_NODES = 128
"""Nodes on the reach of waves whose wavenumbers are summed, or as many as the loads need.  Fields
after 1000 nodes are then off by 1e-4 to 2e-4 in L1 (`preloaded`, `auxetic`, kinks), by 2e-4 to 8e-4
with 64, and by 2e-5 to 7e-5 with 256, in four times the seconds."""
TAPER = 7.0
TAPER_POWER = 8
"""Wavenumbers and frequencies are tapered by exp(-7 s^8), with s their share of the highest, to
1e-3: a power of 4, or 36 or 3 in place of 7, leaves errors up to half as large again."""
WINDOW = 1.5
"""Length of the window in time over that of the march; 2 is no better."""
FADE = 0.25
"""Fraction of the march in which tractions fade out behind its end; 0.1 and 0.4 do the same."""
WRAPPED = 1e-5
"""Factor by which the first window is reduced where it repeats in the second: with 1e-3 errors are
three times as large, 1e-7 gains nothing."""
FIELD_MARGIN = 8
"""Nodes beyond those that waves reach."""
FIELD_VALUES = 1 << 22
"""Tractions that are transformed at once, 32 MB."""
FIELD_LEVELS = 400
"""Number of depths beyond which fields are interpolated in depth; half as many are already three
for the shortest wave."""
LEVEL_DEGREE = 5
"""Degree of that interpolation; its error is below 5e-4 with 200 levels."""
FIELD_CROWD = 4
"""Ratio of all pairs of a depth and a time to those that hold a point, up to which all are formed
at once, by matrix multiplication."""
FIELD_BLOCK = 20_000
"""Pairs that are formed at once otherwise."""
FIELD_POINTS = 60
"""Number of points at which march and companion are compared."""
FIELD_SMOOTHING = 3e-4
"""Largest L1 error that a finer grid does not reduce: 2e-4 (`preloaded`), 3e-4 (kinks)."""
EDGE_SHARE = 1.0
"""Distance from the edge, over 1 / the highest wavenumber, within which the sum takes nothing more
off the stuck intensity: at a twentieth of the shortest wave stress is off by 1 to 2 times itself
(`preloaded`), with 0.6 or 2.4 up to 2.5 times, and by 5 times without."""
