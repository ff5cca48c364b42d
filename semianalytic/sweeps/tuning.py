"""Tuning constants of sweeps, each with the reason for its value or with what it does.

"Half, twice" states what half and twice a value did to sweeps of 60 frictions from 0.05 to 1.5, at
rtol 1e-8, of `preloaded`, `remote-shock`, `auxetic` and `antiplane`, 240 answers.  Work is counted
in values of Cauchy's kernel.  "No effect" means that all edges stayed within 1e-12 c_t and work
within 1 %.  All answers converged throughout, and errors of edges stayed below a quarter of their
estimates.
"""

# Which frictions to try next (continuation)

FIRST_FRICTIONS = 7
"""Frictions that are solved from scratch to begin with.  Half, twice: work 5 % more, 5 % less."""
PREDICTION_REACH = 3
"""Known frictions to either side that a prediction uses.  Half, twice: work 2 % and 7 % more."""
TRIED_BETWEEN = 7
"""Frictions tried at once between two with the same set of zones.  Half, twice: no effect."""
HALVED_GAP = 3
"""Gaps of up to so many frictions are halved.  Half: work 7 % more; twice: 35 answers change, and
the worst error is 0.21 of its estimate, in place of 0.03."""
LEAST_BESIDE_CHANGE = 3
"""Frictions between two sets of zones below which neither set is tried there.  Half, twice:
work 4 % more, 19 % less."""
TRIED_BESIDE_CHANGE = 4
"""Frictions tried at once from either side of a change of zones.  Half, twice: work 16 % less, 2 %
more."""
MOST_INTERPOLATED, LEAST_INTERPOLATED = 8, 5
"""Known frictions that an interpolation goes through, at most and at least.  Half, twice of the
first and twice of the second: 27 to 30 answers change, work does not; half of the second: no
effect."""

# Correction of many frictions at once (batches)

BATCH = 24
"""Sets of zones in one batch: more leave the processor's cache."""
MOST_STEPS = 4
"""Most steps of Newton's method on the loose rule, and of chord steps on a fine one.  Half: work
2 % more; twice: no effect."""
LONGEST_MOVE = 1.5
"""Largest change of an edge unknown in one step, as in `selfsimilar.zones.tuning`.  Half, twice: no
effect."""
NEAR = 2e-3
"""Move of an edge unknown after which its Jacobian is kept.  Half, twice: work 1 % more."""
SLOW = 0.5
"""Ratio of a move to the one before above which Newton's method is given up.  Half: no effect;
twice: work 6 % more."""
CONTRACTION, LEAST_CONTRACTION = 20.0, 1e-3
"""Share of itself that a chord step leaves, over the doubt of its prediction and at least.  Half,
twice of either: no effect."""
TRUSTED_DOUBT = 1e-3
"""Doubt of a prediction below which it needs no Newton's method.  Half: no effect; twice: work 7 %
more."""
LEADING_DOUBT = 0.2
"""Doubt of a prediction below which it needs no full Newton's method: if it leads nowhere, there
are other zones.  Half: no effect; twice: work 1 % more."""
MOST_REFINEMENTS = 3
"""Rules tried until the estimate is below rtol.  Half, twice: no effect."""
LAST_MOVE = 10
"""Longest last move of an edge unknown, over rtol.  Half: no effect; twice: work 3 % less."""
FAR_RULES = 1e-2
"""Ratio of tolerances below which a chord step on a rule between them is taken.  Half, twice: no
effect."""
FASTEST_REFINEMENT = 1e-3
"""Tolerance of a rule over that of the one before, at least.  Half, twice: no effect."""
LOOSEST_LAW = 1e-4
"""Loosest check of Coulomb's law: neighbours' zones may hide one that just begins."""
CLOSE_TO_FRONT = 1e-3
"""Distance in slowness from a front below which differences are formed there."""
BROYDEN_STEPS = 4
"""Steps with neighbours' Jacobians before they are formed anew.  Half: one answer changes; twice:
no effect."""
LOOSE_RTOL = 1e-5
"""Value of rtol from which those steps suffice.  Half, twice: no effect."""

# Interpolation between frictions (interpolation)

LOOSE_CHECK, LOOSE_MOVE = 10, 100
"""Coulomb's law and moves of edges of interpolated zones, in tolerances of the loose rule.  Half,
twice of either: no effect."""
CONVERGING = 0.5
"""Ratio of two successive differences above which the smaller one is no estimate.  Half: four
answers change; twice: no effect."""
DOUBT = 5.0
"""Safety of the estimate: true errors were up to three times the plain one beside thresholds."""
INVERSION_STEPS, INVERSION_NUDGE = 4, 1e-4
"""Newton steps from a friction to the edge unknown there, and their nudge over its range.  Half of
the first: 11 answers change; twice of it, half and twice of the second: no effect."""

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
