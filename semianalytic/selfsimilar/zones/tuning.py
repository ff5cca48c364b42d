"""The numbers that tune the solver and matter in several places or to its answers.

They decide how a solution is found, how fast, and when the search is given up.  Its accuracy is
measured afterwards, by `error_estimate`, whatever they are.  "Half, twice" is what half and twice a
value did, at rtol 1e-8, to 48 random scenes and 30 others whose search is long; work is counted in
values of Cauchy's kernel.  Numbers without such an effect stand where they are used.
"""

# The search: which zones, on which rules (search, guesses)

GRIDS = (48, 96, 192, 384)
"""Nodes of the grids until zones hold: about fifty show those of most scenes."""
STRONGEST_RESISTANCE = 1e15
"""Resistance of slip to its rate, eta [mu b], beyond which slip is rounding of the traction."""
RULE_SHARE = 10.0
"""rtol over the tolerance of a rule that is to reach it. Half, twice: work the same, 8 % more."""
LAW_TOLERANCE = 10
"""Tolerance of Coulomb's law over that of the rule: the noise at nodes is below 1."""

# The refinement of edges and its error estimate (search, estimate)

MOST_BROYDEN_STEPS = 8
"""Broyden steps on one rule. Half: one of 30 hard scenes changes; twice: no effect."""
LEFT_SHIFT, LEAST_LEFT_SHIFT = 0.02, 1e-13
"""Shift of edges left, over rtol and at least. Half, twice: work 1 % more, 3 % less."""
HOPED_ERROR = 0.1
"""Error over rtol that a finer rule is chosen for; below it none is tried."""
FINEST_RULE = 1e-16
"""Finest rule: a film of viscosity 6,800 has 1.2e-11 at 1e-15, 5.1e-11 at 1e-16."""
MOST_NODES = 12_000
"""Nodes of the finest rule: cost grows with their square, 7,000 take 1 s, 19,000 half a minute."""
COARSER_COMPANION = 5.0
"""Companion's tolerance over a rule's: edges are 0.05 of estimates off; half: 0.12, twice: 0.02."""
SAFETY = 5.0
"""Estimate over the difference of two rules: near edges and fronts slip rates change more."""
LEFT_SAFETY = 4.0
"""Safety for edge shifts left, over `SAFETY`: slip rates change fastest at edges."""
SLIP_PER_EXCESS = 0.3
"""Slip rate over the traction that exceeds friction where slip is missed: 0.1 at most."""
LEAST_INTENSITY = 1e-6
"""Share of friction's intensity at a stuck edge in the scale of the edge's own."""

# Newton's method for the edges (edges, placement)

FARTHEST = 300.0
"""Unknowns beyond put an edge on a wave front or at the contact edge: exp(300) is 1e130."""
NUDGE = 1e-6
"""Change of an unknown for its column of the Jacobian: the root of its rounding, 1e-12."""
LONGEST_NUDGE = 0.3
"""Largest nudge of a narrow gap, over its width."""

# Strength that depends on slip rate (folder rated)

MOST_RATE_FIELDS = 200
"""Fields of all Newton steps for a slip rate: 40 at most; next to c_R 1,000 were in vain."""
RATE_SETTLED = 1e-11
"""Change of the slip rate over the largest that ends Newton's method: the next is its square."""
FARTHEST_RATE_REACH = 120.0
"""Longest reach of rules for slip rates of small exponent: at 200 products underflow."""
LEAST_RATE_SHARE = 1 / 32
"""Shortest step from constant friction to a law of friction, over the whole difference."""
STEEP_EXPONENT = 0.06
"""Exponent of slip rate at an edge that a rule of `FARTHEST_RATE_REACH` cuts off at 1e-3."""

# Coulomb's law at nodes and between them (coulomb)

NARROWEST_GAP = 1e-14
"""Stick gaps around c_R narrower than positions x/t in double precision resolve are left out."""
UNDRIVEN_EXCESS = 1e-12
"""Tolerance of K_II over f K_I - 1 at a contact edge that nothing slips at."""

# Zones to begin with (guesses, weak_friction)

WEAK_FRICTION = 0.03
"""Friction over the step of shear below which slip is nearly that without friction."""
NEAREST_TO_C = 1e-16
"""Distance from c in slowness below which changes of sense are rounding."""
POINTS_PER_E = 3
"""Points per factor e of the distance from c at which changes of sense are looked for."""
FRONT_STEP = 0.1
"""Step of the logarithm of the distance behind the longitudinal front. Half: one answer changes."""
GAUSS_PER_ELEMENT = 6
"""Gauss points per element of the grid. Half, twice: eight or nine answers change."""

# Zones after a failure (corrections)

OFF_ENDS = 1e-13
"""Relative distance in slowness from an end of an opening that rounding leaves some digits."""
NEAR_OPENING = 0.05
"""Relative distance in slowness from an opening at which an edge that ran into it is put back."""

# Derivatives with respect to a parameter (folder derivatives)

CLEAR_OF_EDGES = 0.03
"""Distance [c_t] from edges and fronts beyond which the error of a derivative is estimated."""
AT_BORDER = 1e-7
"""Margin of Coulomb's law, width or slip rate below which zones are about to change."""
