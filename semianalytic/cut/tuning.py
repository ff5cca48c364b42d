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

# Panels and their quadrature (panels, totals)

WIDE_PANEL, PANEL_GROWTH, MOST_PANELS = 32.0, 16.0, 12
"""Ratio of the slownesses at its ends from which on a panel behind the shear front is parted, that
of its parts, and how many there are at most: beyond 1e14 they grow.  Under a base 1e6 times the
step, whose slip ends at 1e11, tractions were off by 1e3 times the tolerance of a rule in one panel,
by as much as that tolerance in eleven; halving or doubling the ratio does not show."""
CACHED_KERNEL = 50_000
"""Kernel values formed at once, so that they stay in the processor's cache."""
NARROW_STRIP = 0.01
"""Width in slowness of a zone around c that is narrow.  Half, twice: no edge of 64 random scenes
changes, nor does the work."""
STRIP_AT_CUT_C = 0.5
"""Strip of analyticity, over pi, beside c where slip resists its rate: M + eta vanishes at c + i
eta / m'(c), at right angles from c, however small eta is."""
MANY_NODES = 100
"""Nodes per panel from which it pays to leave some out."""
NEGLIGIBLE_WEIGHT = 1e-6
"""Share of what the reach of a rule leaves out that may be left out as well.  Half, twice: the same
scenes take 0.7 % more, 1.3 % less work, and one answer changes, within its estimate."""
MOST_HALVINGS = 10
"""Most halvings of a panel down to a piece as long as the gap to another panel, for whose nodes a
few points stand.  With 5 and 20 `viscous`, `preloaded`, `remote-shock` and `tap` take the same
time, within its scatter."""
LEAST_SHARE, SHARE_LOGARITHM = 1e-8, 2.0
"""Share of a panel down to which a density beside its end is taken as it is, and the logarithm of
the ratio of the shares of the two nodes from which it is continued further, to 1e-16, the
rounding."""
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
