"""Tuning constants of the fields in the bodies, each with the reason for its value."""

# Transforms off the axis (transform)

FADING = 2
"""Power by which the weights of Cauchy's integral fall off beyond the scale of k: T grows like
k^1/2 at most, so the integrand falls like k^-3/2."""
MIDDLE = 1.0
"""Point at which the axis right of the cut is divided, and the least scale of k: the pole of the
fading factor then sees no panel under more than a right angle, within the strip of the rule."""
BESIDE_POLE = 0.25
"""Distance of a point at which T is taken as known from the pole of a load that moves; of points
1/2 apart one is always farther."""
CACHED_KERNEL = 60_000
"""Values of the kernel that are formed at once, so that they stay in the processor's cache."""
NEGLIGIBLE = 1e-4
"""Nodes are left out that carry less than this fraction of the rule's tolerance, over distance.
Stresses within 1e-9 of a stuck edge are then 8e-12 of themselves off at rtol 1e-10, with 1e-2 2e-10
and with 1e-3 4e-11; the first call takes a few hundredths longer."""

FAR, RING, MANY_SEEN = 4.0, 3, 1000
"""Ratio of distances from a centre from which on nodes are summed up to powers of that ratio, the
width of the rings of cells that share these sums, in steps of cells, and the number of nodes from
which they pay.  A first call at 10,000 points then takes 0.75 to 0.98 of its time.  With a ratio of
3 or 8, rings of 2 or 6 steps, and 500 or 1500 nodes it takes 0.97 to 1.15 times as long."""
LONGER = 28.0
"""Distance in y by which the rule of transforms goes farther than that of zones: T grows like k^1/2
at a stuck edge, and of what a rule leaves out at v the share (k / v)^1/2 is missed."""

# Cells and their polynomials (cells)

SECTORS = 6
"""Cells from one side of the axis to the other."""
DEGREE = 22
"""Degree of the polynomial in ln(k - centre) of a cell, whose nearest singularity is 2.7 half
diagonals from its middle.  Limits on the interface at rtol 1e-11 are then 4e-13 to 4e-12 off, as
with 24; with 18, in the same time, 1e-10."""
CELL_ERROR = 2e-12
"""Error of the polynomials for any rule, over the largest load: up to 5e-13."""
NODES_PER_SIDE = 10
"""Nodes on a side of a cell, in all more than its polynomial has coefficients.  Fields of five
scenes at rtol 1e-11 differ from those with 20 by up to 1e-13 with 14, 12 and 10, and by 1e-12 with
8; the first call takes a seventh less time than with 14."""
COARSE_FROM = 5e-7
"""Tolerance of the rule from which on cells are coarse, that of solutions to 5e-5: pictures while a
slider moves have it, and an error of 1e-5 from the rule."""
COARSE_DEGREE, COARSE_NODES, COARSE_ERROR = 12, 5, 1e-6
"""Degree, nodes on a side, and error of coarse cells.  Fields of seven scenes at 4,000 points each
are up to 3e-7 off those of fine cells over themselves plus the load, in three fifths of the time of
a first picture; with degree 6 and 4 nodes 2e-4 in a tenth less, with degree 9 and 6 nodes 5e-6.
With 4 to 8 nodes and degree 12 they are the same on average, where one of these scenes has the most
with 4."""
SCALES = 16.0
"""Ratio of the scales of k at which transforms are formed."""

# Positions (bodies)

FARTHEST = 1e16
"""Distance over c_t t from which on fields are those at infinity, to rounding."""
NEAREST = 1e-16
"""Distance over c_t t below which a point is the contact edge.  Compared with the closed antiplane
form, stresses beside a stuck edge are off by less than 1e-8 of themselves down to 1e-8, by 6e-7 at
1e-15."""
POINTS_AT_ONCE = 100_000
"""Points that are evaluated at once: working memory stays at some 100 MB."""

# Fields (body)

NEAR_EDGE = 6.0
"""Ratio t / r from which on both waves are added before they are integrated: separately they are
(t / r)^2 times as large as their sum, and lose as many digits."""
NEAR_EDGE_NODES = 10
"""Gauss nodes between k_P and k_S there, which lie within 1 % of k of one another."""
SAME = 4e-16
"""Relative distance at which a slowness from positions and times is that of a singular point."""
CLOSE = (1e-18, 1e-16)
"""Distances from a singular point at which the field at that point is evaluated: a field that grows
from one to the other is infinite."""
GROWN = 1e-6
"""Growth that counts as infinite, relative to the field and to the largest load; finite fields
change like a square root at least, by 1e-8."""
ESTIMATED_POINTS = 60
"""Points at which a coarser rule is compared for the error estimate.  With 30, 60 and 120 the
estimates of `preloaded`, `auxetic`, `pressure-drop` and `antiplane` differ by 5 % at most."""
COARSER = 10.0
"""Tolerance of that rule over the rule's own: its error is then at least twice as large."""

# Fields of a step on a stuck interface (stuck_steps)

STEP_TOLERANCE = 1e-8
"""Tolerance of the rule on which they are formed; marches, which use them, are off by 1e-4 and
more."""
