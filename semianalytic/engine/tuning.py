"""Tuning constants of the engine, each with the measurement that set it (docs/engine.md)."""

from __future__ import annotations

STEP_RATIO = 0.4
"""Shortest step c_t dt / h, which is the lowest rung of the ladder of step lengths."""
LADDER = 2.0
"""Ratio of the step lengths of two rungs: with sqrt(2) errors are the same, and twice as many
tables are kept."""
TABLES = 8
"""Rungs whose tables are kept; at 4,096 nodes and 42 poles each table takes 8 MB."""
SWEEPS = 2
"""Iterations of a step, an even number: a free face grows without bounds with 1 or 3."""
STATE_SHARE = 0.25
"""Largest slip of a step over the slip in which the state of friction changes, xi."""
RATE_SHARE = 0.2
"""Change of the slip rate in a step, over the largest rate, above which steps become shorter.
The other bounds do not see what a load does to a slow interface: slip of TPV101 on 1,440 nodes is
off by 2.1e-3 without this bound, and by 1.2e-4 with 0.2 and with 0.1."""
WAVE_STEPS = 16
"""Least steps in a period of a load.  Slip rate of a slow interface under a harmonic load is off by
3e-4 with 16 and by 2e-4 with 32; with 8 it takes as many steps, because some are repeated."""
HISTORY_SAMPLES = 1001
"""Values of a history that is a function of time, from which the nodes it needs are read: a wave of
60 periods until the end has 16 of them in each.  Half as many see waves of half the frequency."""
LOAD_SHARE = 0.1
"""Part of the range of a load that is a function of time, or of x and t, over which a step passes
at most.  Slip of a quiet fault after a blow of 2 % of the run, a front that passes and fourteen
periods is off by 99, 9 and 8 % without, and by .02, .04 and .7 % with 0.1; with 0.4 by .03, .09 and
.6 %, and with 0.05 as with 0.1 in up to a third more steps."""
BOUND_SHARE = 0.7
"""Share of the longest step at which the iteration of a step still converges."""
TOLERANCE = 1e-7
"""Error of the transform of the memory: with 1e-5 the slip rate of TPV101 changes by 2e-4, with
1e-9 by 5e-7."""
PAIR_TOLERANCE = 1e-6
"""Error of the transforms of the three kernels of different bodies, which take 33 to 59 poles."""
DELAY_NODES = 3.0
"""Least q c_t t* of the shortest wave under a delay t*, without which finer grids show waves that
grow faster."""
SLOT_TOLERANCE = 1e-9
"""Relative residual of the slip rate of slots in long steps: slip under rate-and-state friction
between two slots changes by 3e-13 of itself with 1e-12, and by 6e-10 with 1e-6, which saves a third
of the iterations."""
CROSSINGS = 20.0
"""Times in which a shear wave crosses the line that the sum of exponentials covers: the memory of
an event with its echoes.  Later only the static stiffness acts, which is not part of the sum."""
LARGEST_HORIZON = 1e6
"""Largest q c_t t of a fit: from 1e8 on its values at short times are off by 1e-3."""
LEAST_HORIZON = 100.0
NODES = 512
LEAST_NODES = 8
MOST_NODES = 16384
ZONE_NODES = 3.0
"""Nodes on mu / (fall of strength per slip) from which on a rupture is resolved."""
PART_NODES = 8
"""Nodes on the narrowest contact or slot from which on it is resolved: mean slip of a contact that
is pushed from both sides is 9, 6, 0.3 and 0.1 % off with 2, 4, 8 and 16."""
EDGE_NODES = 4.0
"""Nodes on the slip beside an edge from which on it is resolved: beside a slot that is pushed it is
7, 1.6 and 0.4 % off with 2, 4 and 8, and zero with less than one."""
ERROR_SAFETY = 1.25
"""Estimate of the error over the difference from half the nodes, which is once the error at first
order and three times at second."""
BESIDE_EDGE_ERROR = 0.3
"""Error of a singular traction at the first three nodes beside an edge, summed, over the change of
the first one: 1.35 times the exact value, then .96 and 1.08 times, on any grid (`dissimilar.
grid_edge`; with 200 nodes the sum is .35).  Without it the pressure beside slots that are pressed
together is off by twice its estimate; with half of it, by 1.2 estimates."""
LARGEST_ERROR = 0.5
"""Estimate of slip above which a run is called unresolved unless an `rtol` is given."""
LEAST_GAP = 0.01
"""Part of the slip, in L1, below which a gap decides nothing: beside a slot of different bodies
some nodes open, by 2e-4 of the slip, and differ from grid to grid.  With a tenth of this value the
same runs are resolved; with ten times, the opening of `lift-off-shear`, 6 %, would not count."""
LEAST_MISSED = 1e-6
"""Slip that the nodes beside edges miss, over all slip of contacts and slots, up to which it is
nothing: a contact that sticks up to 2e-7 node distances beside an edge asked for 1e10 nodes."""
TOLD_MISFIT = 0.05
"""Distance of an end of a contact from its place, over the node distance, from which on a run says
what would be better.  Slip of a punch of 102 nodes is off by 0.1 % with ends in their places, by 2,
4 and 12 % with 0.1, 0.2 and 0.5.  The error estimates count any distance."""
SLIPPING_SHARE = 1e-3
"""Slip rate over pressure / impedance beyond which slip under rate-and-state friction has begun:
26 mm/s for TPV101."""
