"""The numbers that tune fields in the bodies, each with what set it."""

# Transforms off the axis (transform)

FADING = 2
"""Power by which the weights of Cauchy's integral fall off beyond the scale of k: T grows like
k^1/2 at most, and what is left falls like k^-3/2."""
MIDDLE = 1.0
"""Where the axis right of the cut is cut in two, and the least scale of k: the pole of what fades
then sees no panel under more than a right angle, within the strip of the rule."""
CACHED_KERNEL = 60_000
"""Values of the kernel formed at once, so that they stay in the processor's cache."""
NEGLIGIBLE = 0.01
"""Share of the tolerance of a rule that a node may carry, over its distance, and be left out."""

LONGER = 28.0
"""How much farther in y the rule of transforms goes than that of zones: T grows like k^1/2 at a
stuck edge, and of what a rule leaves out at v the share (k / v)^1/2 is missed."""

# Cells and their polynomials (cells)

SECTORS = 6
"""Cells from one side of the axis to the other."""
DEGREE = 22
"""Of the polynomial of a cell: of ln(k - centre) over a cell whose nearest singularity is 2.7 half
diagonals from its middle.  Limits on the interface at rtol 1e-11 are then 4e-13 to 4e-12 off, as
with 24; with 18, in the same time, 1e-10."""
CELL_ERROR = 2e-12
"""What polynomials leave however fine the rule, over the largest load: up to 5e-13."""
NODES_PER_SIDE = 14
"""On the border of a cell, more than its polynomial has coefficients."""
SCALES = 16.0
"""Ratio of the scales of k at which transforms are formed."""

# Positions (bodies)

FARTHEST = 1e16
"""Distance over what shear waves do until then from which on fields are those at infinity, to
rounding."""
NEAREST = 1e-16
"""The same below which a point is the contact edge.  Against the closed antiplane form stresses
beside a stuck edge are off by less than 1e-8 of themselves down to 1e-8, by 6e-7 at 1e-15."""
POINTS_AT_ONCE = 100_000
"""What they need beside their fields then stays at some 100 MB."""

# Fields (body)

NEAR_EDGE = 6.0
"""t / r from which on both waves are added before they are integrated: apart they grow like
(t / r)^2 over their sum, and lose as much."""
NEAR_EDGE_NODES = 10
"""Gauss nodes between k_P and k_S there, which lie within 1 % of k of one another."""
SAME = 4e-16
"""Relative distance at which a slowness from positions and times is that of a singular point."""
CLOSE = (1e-18, 1e-16)
"""Distances from a singular point at which a field at that point itself is looked at: what grows
between the two is infinite."""
GROWN = 1e-6
"""By how much it has then grown, relative to itself and to the largest load; what is finite there
comes in like a square root at least, by 1e-8."""
ESTIMATED_POINTS = 60
"""Points at which a coarser rule is compared for the error estimate.  Not recorded."""
COARSER = 10.0
"""How much coarser, in tolerance: its error is then at least twice that of the rule itself."""

# Fields of a step on a stuck interface (stuck_steps)

STEP_TOLERANCE = 1e-8
"""Of the rule on which they are formed; marches, which use them, are off by 1e-4 and more."""
