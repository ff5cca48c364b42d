"""Numbers that tune panels and integrals, each with the observation that determined it."""

# Panels (layout, laying)

WIDE_PANEL, PANEL_GROWTH, MOST_PANELS = 32.0, 16.0, 12
"""Ratio of the slownesses at its ends from which on a panel behind the shear front is parted, that
of its parts, and how many there are at most: beyond 1e14 they grow.  Under a base 1e6 times the
step, whose slip ends at 1e11, tractions were off by 1e3 times the tolerance of a rule in one panel,
by as much as that tolerance in eleven; halving or doubling the ratio does not show."""
NARROW_STRIP = 0.01
"""Width in slowness of a zone around c that is narrow.  Half, twice: no edge of 64 random scenes
changes, nor does the work."""
STRIP_AT_CUT_C = 0.5
"""Strip of analyticity, over pi, beside c where slip resists its rate: M + eta vanishes at c + i
eta / m'(c), at right angles from c, however small eta is."""

# Cauchy integrals between panels (panels)

CACHED_KERNEL = 50_000
"""Kernel values formed at once, so that they stay in the processor's cache."""
MANY_NODES = 100
"""Nodes per panel from which it pays to leave some out."""
NEGLIGIBLE_WEIGHT = 1e-6
"""Share of what the reach of a rule leaves out that may be left out as well.  Half, twice: the same
scenes take 0.7 % more, 1.3 % less work, and one answer changes, within its estimate."""
MOST_HALVINGS = 10
"""Most halvings of a panel down to a piece as long as the gap to another panel, for whose nodes a
few points stand.  With 5 and 20 `viscous`, `preloaded`, `remote-shock` and `tap` take the same
time, within its scatter."""

# Powers beside ends (running)

LEAST_SHARE, SHARE_LOGARITHM = 1e-8, 2.0
"""Share of a panel down to which a density beside its end is taken as it is, and the logarithm of
the ratio of the shares of the two nodes from which it is continued further, to 1e-16, the
rounding."""
