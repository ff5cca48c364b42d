"""Tuning constants of sweeps, each with the reason for its value, "not recorded" if it is lost."""

# Which frictions to try next (continuation)

FIRST_FRICTIONS = 7
"""Solved from scratch to begin with.  Not recorded."""
PREDICTION_REACH = 3
"""Known frictions to either side used to predict.  Not recorded."""
TRIED_BETWEEN = 7
"""Frictions tried at once between two with the same set of zones.  Not recorded."""
HALVED_GAP = 3
"""Gaps up to this are halved.  Not recorded."""
LEAST_BESIDE_CHANGE = 3
"""Frictions between two sets of zones for which neither is tried.  Not recorded."""
TRIED_BESIDE_CHANGE = 4
"""Frictions tried at once from either side of a change.  Not recorded."""
MOST_INTERPOLATED, LEAST_INTERPOLATED = 8, 5
"""Known frictions to interpolate through.  Not recorded."""

# Correction of many frictions at once (batches)

BATCH = 24
"""Sets of zones in one batch: more leave the processor's cache."""
MOST_STEPS = 4
"""Of Newton's method on the loose rule, and of chord steps on a fine one.  Not recorded."""
LONGEST_MOVE = 1.5
"""Of an edge unknown in one step, as in `selfsimilar.tuning`.  Not recorded."""
NEAR = 2e-3
"""Move of an edge unknown after which its Jacobian is kept.  Not recorded."""
SLOW = 0.5
"""Moves that shrink less are given up.  Not recorded."""
CONTRACTION, LEAST_CONTRACTION = 20.0, 1e-3
"""What a chord step leaves of itself, over the doubt of its prediction and at least.  Not
recorded."""
TRUSTED_DOUBT = 1e-3
"""Doubt of a prediction that needs no Newton's method.  Not recorded."""
LEADING_DOUBT = 0.2
"""Doubt of a prediction that needs no full Newton's method: where it leads nowhere there are other
zones.  Not recorded."""
MOST_REFINEMENTS = 3
"""Rules tried until the estimate is below rtol.  Not recorded."""
LAST_MOVE = 10
"""Longest last move of an edge unknown, over rtol.  Not recorded."""
FAR_RULES = 1e-2
"""Tolerances further apart than this take a chord step on a rule between.  Not recorded."""
FASTEST_REFINEMENT = 1e-3
"""Tolerance of a rule over that of the one before, at least.  Not recorded."""
LOOSEST_LAW = 1e-4
"""Loosest check of Coulomb's law: neighbours' zones may hide one that just begins."""
CLOSE_TO_FRONT = 1e-3
"""Distance in slowness from a front below which differences are formed there."""
BROYDEN_STEPS = 4
"""Steps with neighbours' Jacobians before they are formed anew.  Not recorded."""
LOOSE_RTOL = 1e-5
"""rtol from which those steps suffice.  Not recorded."""

# Interpolation between frictions (interpolation)

LOOSE_CHECK, LOOSE_MOVE = 10, 100
"""Coulomb's law and moves of edges of interpolated zones, in tolerances of the loose rule.  Not
recorded."""
CONVERGING = 0.5
"""Differences that shrink less are no estimate.  Not recorded."""
DOUBT = 5.0
"""Safety of the estimate: true errors were up to three times the plain one beside thresholds."""
INVERSION_STEPS, INVERSION_NUDGE = 4, 1e-4
"""Newton steps from a friction to the edge unknown there, and their nudge over its range.  Not
recorded."""

# Neighbours among friction and Poisson ratio (neighbours, plane)

NEIGHBOURS = 32
"""Known points to which a polynomial is fitted."""
NEIGHBOURS_PER_TERM = 1.4
"""Least number of neighbours per term of a polynomial."""
NEAREST_WEIGHT = 0.05
"""Least squared distance over the farthest: neighbours nearer than its root have equal weights."""
LEAST_PIVOT = 1e-14
"""Number added to pivots, for neighbours that lie on a line."""
CERTAIN_NEIGHBOURS = 8
"""Nearest known points that have the same zones where these are not doubted."""
NEAREST_ESTIMATES = 4
"""Nearest known points whose largest error estimate is taken over."""
FARTHEST_STEP = 1e-2
"""Largest chord step on the deciding rule: longer ones say little about the remaining error."""
MOST_DISAGREEMENT = 0.3
"""Largest disagreement of two inverse Jacobians on a step, over that step: a nearly singular one
takes short steps far from the edges' places, and their decrease says nothing.  Two of 3,107
interpolated points of a fine grid were 3 and 18 times their error estimate off, at 0.4 and 44."""
LEAST_LEFT = 0.2
"""Least fraction of a first step that counts as error, however well the two agree: amid far
neighbours both were 17 % off, and agreed to 0.2 %."""
MORE_STEPS = 3
"""Chord steps after the first, if it leaves too large an error."""
LOOSE_SHARE, LEAST_ROOM = 0.5, 0.05
"""Share of the room between neighbours' error estimates and rtol that the rule may use on which
edges are corrected, and the least such room over rtol."""
LACK_ORDER = 1.25
"""Power of a rule's tolerance with which the error of edges falls; 1.5 where edges are sharp."""
RULE_STEP = 0.25
"""Distance between the tolerances of such rules, in powers of ten."""
FIRST_LATTICE = 6
"""Points to a side of the first lattice, solved from scratch; each further one has twice as many
spaces."""
PATTERNS_TRIED = 2
"""Patterns of zones of the nearest known points that are tried."""
PLANE_BATCH = 1.6e5
"""Size of a batch, in units of its count of nodes: 146 points of one edge on a rule of 1e-5, 74 of
three.  Half of it takes 4 % longer, three halves no less; either way 10,000 points leave 310 MB."""
FEWEST_IN_PLANE = 300
"""Points from which neighbours of other Poisson ratios help."""
FRICTIONS_ALONE = 400
"""Frictions to a Poisson ratio from which these do without the other ratios."""
