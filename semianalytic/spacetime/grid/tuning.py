"""Tuning constants of the grid of a march, each with the measurement that set it.

Measurements are those of docs/spacetime.md unless stated otherwise.
"""

from __future__ import annotations

# --- the length of the grid ---------------------------------------------------------------

MARGIN_NODES = 8
"""Nodes beyond the reach of waves on either side.  Without any, 6e-4 of the largest slip rate comes
back from the mirrors (`remote-shock`, 400 nodes); from two on nothing changes."""

# --- a step on the grid -------------------------------------------------------------------------

SWEEPS = 2
"""Iterations of a step, an even number: with one or three, marches grow without bounds.  With two
and four the slip rate is off by 0.038 and 0.040 % (`preloaded`), 0.192 and 0.196 %
(`remote-shock`), 0.433 and 0.432 % (`auxetic`), 400 nodes."""
AREA = 1.5
"""Stretch of the line over which a node takes the mean of what slips, in node distances.  With 0,
1.5 and 2 the slip rate of `antiplane` is off by 2.6e-4, 0.9e-4 and 0.3e-4 (1,024 nodes), and that
of a zone a thirteenth of the contact long by 4.0, 1.8 and 3.0 % (256 nodes)."""

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
WEAKENING_NODES = 8.0
"""Nodes in the process zone of slip weakening from which on slip and frictional work are right to
1 %: off by 0.6 and 0.6 % with 8, 0.9 and 1.0 % with 6, in the worst of three scenes."""
LEAST_WEAKENING_NODES = 2.0
"""Nodes in the process zone below which the grid, not the law, sets its length: slip is off by 4 %,
its rate by 22 %."""

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
TABLE_BYTES = 8
"""Bytes per sample of the pressure table."""
LARGEST_FEEDBACK = 0.95
"""Largest feedback of the shortest wave: the iteration of a step diverges from 1 on."""
