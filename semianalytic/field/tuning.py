"""Tuning constants of the fields in the bodies, each with the reason for its value."""

# Transforms off the axis (transform)

NEGLIGIBLE = 1e-4
"""Tolerance of nodes left out: stresses 1e-9 from a stuck edge are 8e-12 off, with 1e-3 4e-11."""

FAR, MANY_SEEN = 4.0, 1000
"""Ratio from which nodes are summed by powers, and their least number: 0.75 to 0.98 of the time."""

# Cells and their polynomials (cells)

SECTORS = 6
"""Cells from one side of the axis to the other."""
CELL_ERROR = 2e-12
"""Error of the polynomials for any rule, over the largest load: up to 5e-13."""
COARSE_FROM = 5e-7
"""Tolerance from which on cells are coarse: that of pictures while a slider moves."""
COARSE_ERROR = 1e-6
"""Error of coarse cells: up to 3e-7 in seven scenes at 4,000 points each."""
SCALES = 16.0
"""Ratio of the scales of k at which transforms are formed."""

# Positions (bodies)

POINTS_AT_ONCE, POWERS_AT_ONCE = 200_000, 2000
"""Points that are evaluated at once: working memory stays at some 100 MB; and those of a cell."""

# Fields (body)

NEAR_EDGE = 6.0
"""Ratio t / r from which both waves are added first: alone they are (t / r)^2 times as large."""
SAME = 4e-16
"""Relative distance at which a slowness from positions and times is that of a singular point."""
CLOSE = (1e-18, 1e-16)
"""Distances from a singular point; a field that grows from one to the other is infinite."""
COARSER = 10.0
"""Tolerance of a companion over the rule's own: its error is then at least twice as large."""
