"""Tuning constants of sweeps, each with the reason for its value or with what it does.

"Half, twice" states what half and twice a value did to sweeps of 60 frictions from 0.05 to 1.5, at
rtol 1e-8, of `preloaded`, `remote-shock`, `auxetic` and `antiplane`, 240 answers.  Work is counted
in values of Cauchy's kernel.  "No effect" means that all edges stayed within 1e-12 c_t and work
within 1 %.  All answers converged throughout, and errors of edges stayed below a quarter of their
estimates.
"""

# Correction of many frictions at once (batches)

MOST_STEPS = 4
"""Newton steps on the loose rule, chord steps on a fine one. Half: work 2 % more."""
NEAR = 2e-3
"""Move of an edge unknown after which its Jacobian is kept. Half, twice: work 1 % more."""
SLOW = 0.5
"""Ratio of a move to the one before above which Newton's method ends. Twice: work 6 % more."""
LEAST_CONTRACTION = 1e-3
"""Least share of itself that a chord step leaves."""
TRUSTED_DOUBT = 1e-3
"""Doubt of a prediction below which it needs no Newton's method. Twice: work 7 % more."""
LOCATED = 5e-4
"""Doubt of zones located on the loose rule, in which the fine rule is trusted to correct them."""
LEADING_DOUBT = 0.2
"""Doubt below which a prediction needs no full Newton's method: else zones are others."""
BENT = 30.0
"""What a first chord step leaves over its square, behind Newton's method on a coarser rule."""
LOOSEST_LAW = 1e-4
"""Loosest check of Coulomb's law: neighbours' zones may hide one that just begins."""
COARSEST = 1e-3
"""Tolerance of the rule on which edges are approached to `NEAR`: 1e-4 takes 5 to 10 % longer."""

# Neighbours among friction and Poisson ratio (neighbours, plane)

LOOSE_CHECK = 10
"""Coulomb's law of interpolated zones, in tolerances of the loose rule."""
CERTAIN_NEIGHBOURS = 8
"""Nearest known points that have the same zones where these are not doubted."""
LACK_ORDER = 1.0
"""Power of a rule's tolerance with which the error of edges falls at least.  Half of it takes 20 %
longer; with 1.25, which saves 5 %, 9 of 220 drawn sweeps over friction were beyond their estimates.
"""
LEAST_LACK, MOST_RISING = 1e-12, 100.0
"""Least error of edges on a loose rule that counts, and the largest ratio of such errors among
neighbours that does: its root is how much larger a point's error may be."""
NARROW_GAP = 1e-3
"""Width of a stick gap, in slowness, below which a set of each batch is solved for on its own."""
RULE_STEP = 0.25
"""Distance between the tolerances of such rules, in powers of ten."""
PLANE_BATCH = 1.6e5
"""Size of a batch in its count of nodes: half takes 4 % longer; 10,000 points leave 310 MB."""
