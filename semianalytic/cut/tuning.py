"""Numbers that tune the fields of given zones, each with the observation that determined it."""

# Friction that does not count (load)

NEGLIGIBLE_FRICTION = 1e-15
"""Strength over the step of shear that rounding alone would take from it."""
LEAST_BASE = 1e-30
"""Base pressure over its step, or step over base, that is nothing beside it: an opening ends within
1e-60 of a wave front or of the contact edge there."""
CRITICAL_BASE = 1e-14
"""Relative difference of a base from friction below which it counts as at friction: the rounding of
the two products."""

# Totals, and the largest slip (profile, totals)

BESIDE_BORDER = 0.1
"""Share of a panel beside a border of an opening where slip rate is infinite, of no account for the
largest.  Half, twice: under films of viscosity 0.05, 0.5 and 5 (`lift-off-shear`) that
largest value changes by up to 16 %, and edges and estimates do not."""
TOTALS_STRIP = 0.8
"""Spacing of the rule of running totals over that of the panels: on the same rule work at points
between nodes was off by up to four times its tolerance, on this one by a tenth of it."""
EARLIEST = 1e-200
"""Slowness of what has not begun."""
PIECE_GROWTH = 4.0
"""Ratio of the slownesses of the ends of a piece towards a slipping contact edge.  Half, twice and
four times: errors of slip and work of six named scenes are at most 0.036 of their estimates, as
with 4."""
ZOOM_POINTS, ZOOMS = 33, 6
"""Points in a bracket around the largest slip, which each zoom narrows 16 times; the last is 10^-7
as wide: slip, flat at its maximum, is right to rounding."""
