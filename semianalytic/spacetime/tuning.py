"""Tuning constants of the space-time solver, each with what set it.

Measurements are of docs/spacetime.md unless told otherwise.
"""

from __future__ import annotations

# --- the march --------------------------------------------------------------------------------

NODES = 1000
"""Observed nodes unless given: 0.01 % of slip rate (`preloaded`) in 0.3 s."""
LEAST_NODES = 16
MOST_NODES = 8000
"""That a march chooses by itself, some 20 seconds of work."""
MARGIN_NODES = 8
"""Beyond what waves reach on either side: those of the grid run ahead of the true ones a little."""
LARGEST_STEP_RATIO = 2.0
"""c_t dt / h that is tried at all; from 0.5 to 0.7 on, by Poisson ratio, the feedback refuses."""
SWEEPS = 2
"""Iterations of a step."""
LARGEST_FEEDBACK = 0.95
"""Of the shortest wave: the iteration of a step diverges from 1 on."""
AVERAGED_BREAKS = 2
"""Breaks of a load within a step from which on a level takes the mean: one kink is told by its
values at the levels, several are not."""
WEAKENING_NODES = 2.0
"""Nodes within which slip weakening may localise."""
TOLERANCES = (1e-11, 1e-2)
"""Of the memory's transform; below, rounding of the fit is in the way."""
ONSET_SHARE = 0.01
"""Part of the largest slip rate so far that counts as the beginning of slip."""

# --- the memory as a sum of exponentials ------------------------------------------------------

SAMPLES = 60
"""Points of the transform on each of five stretches; the fit is checked on four times as many."""
MOST_PAIRS = 60
"""Of conjugate poles; the finest tolerance takes some 40 poles."""
FAR_SAMPLE = 30.0
"""Largest s of samples, where G - 1 has become its tail 1/s^2."""
SHORTEST_SAMPLE = 0.1
"""Smallest distance of samples to the branch points, over 1 / horizon."""

# --- what a grid follows ----------------------------------------------------------------------

LARGEST_TURN = {1: 0.08, 4: 0.32}
"""Of a load within so many steps h / (2 c_t), over its largest value: frictional work is off by 1
to 3 % then."""
STEP_RATIO = 0.5
"""c_t dt / h of those steps; smaller ones do not help."""
ZONE_NODES = 4.0
"""In a slip zone at the edge, from which on it counts as resolved: frictional work is 2.3 % off."""
HALVINGS = 50
"""Bisections of the step that follows a load, ended at 0.1 %."""
TIMES = 2000
"""At which the slip zone at the edge is looked at, fewer where a load has many breaks."""
LEAST_TIMES = 40
MOST_SAMPLES = 4 * 10**6
"""Times times breaks: 0.1 s of work."""
NO_INTENSITY = 1e-9
"""Excess of the stress intensity over friction, relative, that is rounding."""

# --- the pressure on the grid -----------------------------------------------------------------

EXACT_KINKS = 4
"""Up to which kinks are exact at every level; a table costs as much as some five."""
TABLE_SAMPLES = 2
"""Of a table per time step."""
TABLE_ROWS = 64
"""Nodes whose responses are convolved at once, to stay in the cache."""
BLOCK_VALUES = 1 << 16
"""Pressures that are made at once, for the same reason."""

# --- the memory of the machine ----------------------------------------------------------------

LEAST_LEVELS = 16
"""That are stored at the least."""
TYPICAL_POLES = 25
"""Before the fit tells: 15 to 40."""
BYTES_PER_POLE = 80
"""And node of the grid, at the peak of a march: five complex arrays, measured."""
BYTES_PER_NODE = 400
"""Of the grid besides, measured."""
BYTES_STORED = 32
"""Per observed node and level: four fields."""
BYTES_PER_STEP = 96
"""Times, loads and totals."""
TABLE_BYTES = 8
"""Per sample of the pressure's table."""
