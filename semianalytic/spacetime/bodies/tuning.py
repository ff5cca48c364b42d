"""Tuning constants of marched fields in the bodies, each with the measurement that set it.

Measurements are those of docs/spacetime.md unless stated otherwise.
"""

from __future__ import annotations

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
