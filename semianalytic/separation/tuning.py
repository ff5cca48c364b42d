"""Tuning constants of the normal problem, each with the reason for its value."""

import numpy as np

FIRST_RULE, LOOSE_RULE = 1e-2, 1e-3
"""Tolerance of the rules on which edges are tried to begin with, and looked for, at most."""
LOOSE_SHARE, LEAST_LOOSE = 0.1, 1e-12
"""Tolerance of the loose rule over the relative distance of the base below the threshold, and its
least value: the width of the opening grows like the root of that distance."""
CLOSINGS = np.linspace(np.log(0.3), np.log(60.0), 6)
"""Logarithms of distances of the closing edge from c that are tried, over that of the opening edge:
three times as far beside the threshold (docs/separation.md), 25 times at nu = 0.49."""
LOGITS = np.linspace(-40.0, 40.0, 321)
"""Logits of places between the longitudinal and the Rayleigh front at which the stuck pressure is
evaluated."""
OPENINGS, NEAR_FRONT, FARTHER, BESIDE_CUT = 4, -1.0, 0.9, 0.05
"""Number of opening edges that are tried; the logit of the zero of the stuck pressure below which
they go to half of it (measured: 0.5 to 0.97 of it), and how far they go beyond it elsewhere
(measured: 0.1 to 0.6); the share of the way to a cut that is left.  So Newton's method starts 0.03
and 0.01 off (medians over a hundred scenes), and takes two steps."""
MOST_NEWTON_STEPS = 30
"""Most steps of Newton's method; five are the rule.  Half, twice: no effect on 24 random scenes
with Coulomb friction."""
LONGEST_MOVE = 2.0
"""Largest change of an unknown, a logit or a logarithm, in one step."""
NUDGE = 1e-6
"""Change of an unknown for its column of the Jacobian: about the root of 1e-12."""
LAST_MOVE = 1e-2
"""Move of an unknown after which the Jacobian is kept and the rule is made finer."""
MOST_CHORD_STEPS, LEAST_MOVE = 12, 1e-13
"""Most steps on the finer rule, and the least move that ends them, besides half the tolerance."""
COARSER_COMPANION = 5.0
"""Tolerance of the rule with which edges are compared, over that of the rule itself."""
SAFETY = 15.0
"""Error estimate over the difference of two rules: the rate of the gap changes several times as
much as the edges, relative to itself."""
NARROW = 0.2
"""Width [c_t] below which edges are to be known over the width: the gap's error over its size is
about 15 times theirs over the width, which `SAFETY` leaves room for down to here."""
LEAST_ERROR = 1e-14
"""Rounding error, which is part of every estimate."""
RULE_SHARE, LEAST_TOLERANCE = 1e-2, 1e-14
"""Tolerance of the rule of the normal problem over what is asked for, and at least: shear is to
find nothing missing in it.  Finer by the same share where edges are not placed that well."""
EDGE_SHARE = 0.2
"""Largest error of edges over the requested one that is good enough."""
BETWEEN_NODES = 6.0
"""Error of the gap at points between nodes over the tolerance of a rule, relative to its largest:
at most 4.5 was seen, beside the threshold in all scenes; of its rate, away from edges and c, 0.25.
"""
AT_SHEAR_FRONT = 1e-14
"""Distance from the shear front, in slowness, that is rounding of sums."""
