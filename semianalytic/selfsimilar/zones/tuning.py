"""The numbers that tune the solver, each with what set it or with what it does.

They decide how a solution is found, how fast, and when the search is given up.  Its accuracy is
measured afterwards, by `error_estimate`, whatever they are.

"Half, twice" states what half and twice a value did, at rtol 1e-8, to 48 random scenes of Coulomb
friction, and to 30 others that need a second set of zones or more than six steps
(docs/studies/constants.py).  Work is counted in values of Cauchy's kernel.  "No effect" means that
all edges stayed within 1e-12 c_t and work within 1 %.  All answers converged with the same zones
throughout, and errors of edges stayed below 0.12 of their estimates.
"""

# The search: which zones, on which rules (search, guesses)

GRIDS = (48, 96, 192, 384)
"""Nodes of the complementarity grids, one after the other until zones hold: about fifty show the
zones of most scenes (docs/solver.md), the finer ones are for the rest."""
MOST_ZONE_SETS = 12
"""Sets of zones tried from one start.  Half, twice: no effect."""
LOOSEST_RULE = 1e-4
"""Tolerance of the rule on which zones are looked for, at most.  Half, twice: work 11 % and 3 %
less in the 48 scenes, of which 20 and 13 change."""
STRONG_RESISTANCE = 1e8
"""Resistance of slip to its rate, eta [mu b], beyond which zones are sought on strict rules at
once: loose ones leave errors in the traction that exceed what drives slip.  From 1e10 on the
search on loose rules was in vain."""
STRONGEST_RESISTANCE = 1e15
"""Resistance of slip to its rate, eta [mu b], beyond which slip is rounding of the traction and
zones fail."""
RULE_SHARE, RULE_SHARE_AT_POLE = 10.0, 20.0
"""rtol over the tolerance of a rule that is to reach it, elsewhere and where slip covers c: there
`BETWEEN_NODES_AT_POLE` leaves room for the rest of an estimate.  Half, twice of the first: work the
same, 8 % more."""
COARSER_LOCATING = 3.0
"""Rules are much better than their tolerance as far as edges go: edges are first located on one
this much looser than the one on which Coulomb's law is checked."""
LOCATED_SHIFT, LEAST_LOCATED_SHIFT = 0.1, 1e-7
"""Shift of edges [c_t] that ends Newton's method in the search, over rtol and at least.  Half,
twice of either: no effect."""
LAW_TOLERANCE = 10
"""Tolerance of Coulomb's law in the search over that of the rule: the noise at nodes is below 1."""
STRICT_RULE = 1e-9
"""Tolerance of the rule of a second search: what hardly slips is driven by less than a loose rule
can tell."""
STRICTER, STRICTEST = 1e-3, 1e-12
"""Tolerance of the answer of a second search, over rtol and at least.  Half, twice of either: no
effect."""

# The refinement of edges and its error estimate (search, estimate)

MOST_REFINEMENTS = 8
"""Rules tried until the estimate is below rtol.  Half, twice: no effect."""
MOST_BROYDEN_STEPS = 8
"""Broyden steps on one rule.  Half: one of the 30 scenes changes; twice: no effect."""
LEFT_SHIFT, LEAST_LEFT_SHIFT = 0.02, 1e-13
"""Shift of edges that another Broyden step would bring in the end, over rtol and at least.  Half,
twice of the first: work 1 % more, 3 % less; of the second: no effect."""
HOPED_ERROR = 0.1
"""Error over rtol that a finer rule is chosen for; below it no finer rule is tried.  Half, twice:
no effect but that twice changes one of the 30 scenes."""
SLOWEST_REFINEMENT, FASTEST_REFINEMENT = 0.1, 1e-2
"""Tolerance of a rule over that of the one before, at most and at least.  Half, twice of the
first: no effect; of the second: two of the 30 scenes change."""
FINEST_RULE, LEAST_GAIN = 1e-16, 0.5
"""Tolerance of the finest rule that is tried, and what it must leave of the estimate: beyond that
only rounding changes.  In an opening film of viscosity 6,800 estimates on rules of 1e-13, 1e-15 and
1e-16 were 2.6e-11, 1.2e-11 and 5.1e-11."""
MOST_NODES = 12_000
"""Nodes of the finest rule that is tried, all panels together: cost grows with their square, 7,000
take one second, 10,000 two and a half, and 19,000 half a minute.  Without strong films that open no
scene comes near."""
COARSER_COMPANION = 5.0
"""Tolerance of the rule an answer is compared with, over its own.  Errors of edges are at most 0.05
of their estimates; half: 0.12, work 2 % more; twice: 0.02, work 7 % more."""
SAFETY = 5.0
"""Error estimate over the difference of two rules: slip rates near edges and fronts change more
than the quantities compared."""
LEFT_SAFETY = 4.0
"""Safety factor for edge shifts that are left, over `SAFETY`: slip rates change fastest beside
edges."""
LEAST_ERROR = 1e-14
"""Rounding, part of every estimate.  Half, twice: no effect at rtol 1e-8."""
BETWEEN_NODES, BETWEEN_NODES_AT_POLE = 0.3, 7.0
"""Error at points between nodes over the tolerance of a rule, of slip rate, slip and path over
their largest, elsewhere and where slip covers c: 0.1 was seen elsewhere, and there 1.0 of slip
rate, 5.7 of path in 300 scenes that open."""
TRACTION_ROUNDING = 5e-15
"""Rounding of tractions at nodes, relative to strength plus load.  Half, twice: no effect."""
SLIP_PER_EXCESS = 0.3
"""Slip rate over the traction that exceeds friction where slip is missed: 0.1 was seen."""
MISSED_SAFETY = 4.0
"""Factor of the slip that is missed in the estimate where it is more than the wanted accuracy.  Of
35 scenes whose base lacks 1e-13 to 1e-8 of friction, errors were at most 2.2 times as large as
without this factor.  Half: 1.1 times their estimate; twice: 0.3."""
NEARLY_AT_FRICTION, SMALL_STEP = 1e-8, 1e-2
"""Share of friction that a base lacks, and step over friction, below which a status that is not
"converged" says so: in 18 kinds of scene bases at friction and all that lack 1e-8 or more converge,
11 of those that lack 1e-10 do not."""
LEAST_IMPEDANCE = 1e-3
"""Least impedance [rho c_t] that such slip is divided by, over `SLIP_PER_EXCESS`: it falls to 0 at
the longitudinal front for nu near 0."""
COVERED_GAIN = 6.0
"""Largest slip rate of each zone over its time of slip, over the largest slip, up to which
`SAFETY` covers slip.  It is below 4 in 4,069 of 4,264 scenes of the campaign; in the other 195 slip
is off by at most 0.73 of its estimate, by 0.57 and 0.50 in two where it is 12 and 16; half: 0.29
and 0.25, twice: 1.1 and 1."""
POWER_SAFETY = 1.0
"""Error estimate over the difference of frictional power between two rules where slip covers c.
Where the contact nearly opens at c, errors were 0.25 and 0.22 of their estimates in two scenes of
the campaign; half: 0.50 and 0.39, twice: 0.13 and 0.14."""
FILM_SAFETY = 2.0
"""Error estimate over the largest difference of two rules between the nodes of a film that opens.
Two scenes of the campaign were up to 5.9 times their estimates off without it; errors are now 0.15
of them, half and twice: at most 0.17, since the rules that are chosen change with it."""
LEFT_AHEAD = 3.0
"""Shift that may be left of the edge of slip ahead of an opening, over that of others, per width in
slowness: with `WORK_AHEAD` what is left then takes a fifth of rtol."""
INTENSITY_SAFETY = 1.0
"""Error estimate over the difference of two rules, of the stress intensity at a stuck contact edge:
the finer of them is much better than that."""
LEAST_INTENSITY = 1e-6
"""Share of what friction holds at a stuck contact edge that is added to the stress intensity as the
scale of its error: the intensity may be much less, and then most of its digits are lost."""
WORK_AHEAD = 3.0
"""Power of its width that friction takes on the slip ahead of an opening, about."""
GAP_LOGARITHM_SHARE = 0.1
"""Share of a change of the logarithm of an edge's distance from c that counts as a shift: the slip
rate beside a narrow stick gap follows the logarithm of its width."""

# Newton's method for the edges (edges, placement)

MOST_NEWTON_STEPS = 40
"""Most steps of Newton's method.  One or two are the rule (docs/solver.md); 30 random scenes
that need a second set of zones took 8 at most, so that half and twice have no effect on them."""
MOST_HALVINGS = 8
"""Most halvings of a step that does not reduce the mismatch.  Half, twice: no effect."""
LONGEST_MOVE = 1.5
"""Largest change of a logit or logarithm in one step.  Half: work 2 % more in the 30 scenes; twice:
no effect."""
CAUTIOUS_MOVE = 1.0
"""Longer moves are checked for natural monotonicity.  Half: work 2 % more in the 30 scenes; twice:
no effect."""
FARTHEST = 300.0
"""Unknowns beyond put an edge on a wave front or at the contact edge: exp(300) is 1e130."""
NUDGE = 1e-6
"""Change of an unknown for its column of the Jacobian, about the root of 1e-12, the rounding of the
mismatch.  Half: work 2 % more in the 30 scenes, two of which change; twice: one changes."""
GAP_ROUNDING, LONGEST_NUDGE = 1e-13, 0.3
"""A nudge of a narrow gap changes it by this share of its distance from a front, which rounding
does not hide, but by no more than that share of itself."""
NEAR_ROOT, SHORTEST_ROOT = 1e-3, 1e-3
"""Distance in slowness from the longitudinal front below which an edge is moved by the root of its
distance, and the least share of that root that is left: a strip of 1e-18 that a base just below
friction keeps stuck is found in three steps, where steps of its logarithm by two took twenty."""
UNSEEN_CHANGE, LONGER_NUDGE = 1e-13, 1e3
"""Change of the mismatch by a nudge below which rounding counts, and the factor that lengthens it.
With 1e-6 of a distance of 1e-18 from the longitudinal front Jacobians were thirty times off."""
LEAST_WIDTH = 1e-10
"""Least width of a zone, over its distance from a front; rounding spoils narrower ones."""

# Strength that depends on slip rate (folder rated)

MOST_RATE_STEPS, MOST_RATE_FIELDS = 12, 200
"""Newton steps for the slip rate, of which four are the rule, and fields that they take altogether,
those of the iterations included whose term holds the new slip rate.  Of the scenes of the campaign
that converge none took more than 40: half, twice have no effect on them.  Next to c_R, where no
rule resolves slip rate, a thousand took a minute in vain."""
MIXED_ITERATES = 6
"""Earlier iterates from which, besides the last, the next is made.  Half, twice: no effect on 16
random scenes of other laws, of which 10 have a solution."""
RATE_ROUNDING, RATE_SETTLED = 1e-13, 1e-11
"""Change of the slip rate, over the largest, that ends these iterations, and the steps: the next
step would be the square."""
FARTHEST_RATE_REACH = 120.0
"""Reach in y of rules that are made longer for slip rates of small exponent beside edges: at 200
products of distances underflow."""
MOST_RATE_EDGE_STEPS = 16
"""Steps by which edges are located about a slip rate: of sixty scenes that were solved one took 12,
all others at most 8.  Next to c_R, where no rule resolves slip rate, forty took seconds in vain.
"""
LOOSEST_RATE_RULE, FINEST_RATE_RULE = 1e-5, 1e-13
"""Tolerances of the first rule, and the least.  Half, twice of either: no effect on the same
scenes."""
RATE_RULE_SHARES = (0.1, 0.01)
"""Tolerances of the rules after it, over rtol, one after the other until the error is below rtol:
what the length of a rule leaves out no finer one brings back."""
LEAST_RATE_SHARE = 1 / 32
"""Shortest step from constant friction to a law of friction, over the whole difference, that is
tried where the law is not reached at once.  Half, twice: no effect on the same scenes."""
STEEP_EXPONENT = 0.06
"""Exponent of slip rate beside an edge that a rule of `FARTHEST_RATE_REACH` cuts off at 1e-3."""

# Coulomb's law at nodes and between them (coulomb)

NARROWEST_GAP = 1e-14
"""Stick gaps around c_R narrower than positions x/t in double precision resolve are left out."""
UNDRIVEN_EXCESS = 1e-12
"""Tolerance of K_II over f K_I - 1 at a contact edge beside which nothing slips.  Half, twice: no
effect."""
WIDEST_FIRST_EDGE_ZONE, SLOWEST_EDGE = 0.02, 1e60
"""Excess of K_II that the first width of a zone at the contact edge is taken from (half, twice: no
effect), and the slowness [1 / c_t] up to which it is looked for: under a base 1e6 times the step
such a zone ends at 1e12."""
HIDING_REACH = 8.0
"""Distance in y beyond which nodes lie closer together than anything that could hide between
them."""
PARABOLA_ERROR = 3e-3
"""Error that a parabola through three nodes may have.  Half, twice: no effect."""
CLOSER_POINTS = 8
"""Points per node distance, and again per distance of these, at which Coulomb's law is checked
where a parabola comes near to its bound.  Half, twice: no effect."""

# Zones to begin with (guesses, weak_friction, first_front)

EDGE_SHARE, EDGE_SHARE_SLOPE = 0.25, 0.75
"""Place of an edge between two nodes of a grid, from the ratio r of the two outermost slip rates:
0.25 + 0.75 r.  Measured: median error of the unknowns 0.02 over a hundred random scenes."""
NARROW_AT_EDGE = 0.02
"""Distance from the contact edge [c_t] within which slip around an opening is sought without a
grid, whose coarsest has two nodes there.  In 60 random openings under bases 10 to 1e6 times the
step, half: work as before, twice: 1 % more; with grids alone 4 fail, and work is 2.7 times as
much."""
BESIDE_OPENING = 0.3
"""Place of an edge that a grid puts within an opening, from there to the next node.  Half, twice:
no effect."""
EDGE_SHARE_UNKNOWN = 0.5
"""Ratio of slip rates assumed where there is only one node.  Half, twice: no effect."""
FARTHEST_SHARE, SHARE_BEFORE_NODE, SHARE_TO_OTHER_SENSE = 1.25, 0.95, 0.4
"""Largest value of that share: towards stick, towards a front or a narrow gap, and towards slip of
the other sense.  Half, twice of the first: up to eight answers change, work does not."""
WEAK_FRICTION = 0.03
"""Friction over the step of shear below which slip is nearly that without friction.  On 16 random
scenes below it, half: work 3 % less, one answer changes; twice: no effect."""
WIDEST_GAP = 1.2
"""Largest width of a gap over its distance from c; beside a narrow strip it is below 4 / pi."""
FRICTIONLESS_RULE = 1e-6
"""Tolerance of the rule of the frictionless slip rate.  Half, twice: no effect on the same
scenes."""
FRICTIONLESS_NOISE = 1e-2
"""Noise of a slip rate over the tolerance of its rule; V is no less just behind the front."""
NEAREST_TO_C, FARTHEST_FROM_C = 1e-16, 1e6
"""Distances in slowness between which changes of sense are looked for: rounding, and the contact
edge."""
POINTS_PER_E = 3
"""Points per factor e of the distance from c at which they are looked for.  A third, twice: no
effect on the same scenes."""
GAP_SLOPE_STEP = 1e-4
"""Relative step of the distance from c for the slope of V where a gap opens.  Half, twice: no
effect on the same scenes."""
NEAREST_TO_FRONT, NARROWEST_FRONT_ZONE = 1e-16, 1e-11
"""Distance in slowness behind the longitudinal front from which slip is looked for, and the
narrowest zone there; of less rounding shows nothing."""
FRONT_STEP = 0.1
"""Step of the logarithm of the distance behind the longitudinal front.  Half: one answer changes;
twice: no effect."""
GAUSS_PER_ELEMENT = 6
"""Gauss points per element of the complementarity grid.  Half, twice: eight or nine answers
change, work does not."""

# Zones after a failure (corrections)

NO_ZONE = 1e-9
"""Width of slip beside an opening that is none, over the lesser of its velocity and c_t: out of the
plane nothing drives it ahead of the shear front."""
OFF_ENDS = 1e-13
"""Distance in slowness, relative, from an end of an opening that rounding leaves some digits."""
NARROW_GAP = 0.1
"""Gap over slowness between zones that may have met.  Half, twice: no effect."""
NEAR_OPENING = 0.05
"""Relative distance in slowness from an opening at which an edge that ran into it is put back.
Half, twice: no effect."""
AT_OPENING, NEAR_CLOSING = 1e-6, 0.05
"""Relative distance of slip that begins where an opening closes (half, twice: no effect), and its
distance over its own width: at nodes of loose rules it was seen to begin 0.003 of that behind."""
VANISHED_ZONE = 1e-4
"""Width over slowness of a zone that Newton's method has all but closed.  Half, twice: no
effect."""
AT_SHEAR_FRONT = 1e-4
"""Distance in slowness from the shear front within which an edge counts as having run into it.
Half, twice: no effect."""
BEHIND_SHEAR_FRONT, AHEAD_OF_SHEAR_FRONT = 0.1, 0.02
"""Place where an edge that ran into the shear front restarts on the other side, over the segment
there.  Half, twice of either: no effect."""

# Derivatives with respect to a parameter (folder derivatives)

VARIED_STEP = 3e-3
"""Step of logits and logarithms between neighbours; truncation and rounding are each some 1e-11."""
MOST_NARROWINGS, FASTEST_NARROWING = 8, 1e-2
"""Times such a step is made shorter where it changes the width of a panel by more than that share,
and by how much at most each time: a strip of 1e-14 is reached."""
VARIED_OPENING = 1e-12
"""Accuracy of the openings between which is differenced."""
DIRECTION_RULE = 1e-6
"""Tolerance of the rule on which the direction of a derivative is found: as good as a Jacobian from
one-sided differences."""
MOST_IMPROVEMENTS, NEGLIGIBLE_CHANGE = 4, 1e-11
"""Most improvements of a direction, of which one is usual, and the relative change below which it
is left."""
UNSEEN_SAFETY = 20.0
"""Error estimate of a derivative over the difference of two rules, in place of `SAFETY`, where two
edges are so close that no compared velocity lies between them: differences of their mismatch are
then mostly rounding.  With 5 one of 60 random films that open, with slip on a strip of 0.006 c_t,
was 1.7 times its estimate off, with 10 0.6 times; all others stay below their estimates with 5."""
LEAST_DERIVATIVE_ERROR = 1e-10
"""Rounding of differences, part of every estimate of a derivative."""
CLEAR_OF_EDGES, COMPARED_POINTS = 0.03, 100
"""Distance [c_t] from edges and fronts beyond which the error of a derivative is estimated, and the
velocities from there to c_l at which it is."""
NEAREST_COMPARED = 1e-6
"""Velocity [c_t] from which on it is estimated again where the contact edge slips: a film of
resistance 65 slipped on 0.046 c_t alone, and of 100 velocities from 0.03 c_t on none lay in that
zone 0.03 c_t from its end; its estimate was 2.4 times too small.  Half, twice: no effect."""
COMPANION_STEP = 0.7
"""Step of the differences of a companion, over that of what it is compared with: truncation, of
fourth order, shows by three quarters."""
UNSEEN_LACK, UNSEEN_STRIP = 1e-6, 1e-9
"""Largest shortfall of a base from friction, over friction, and how wide in slowness the strip may
be that sticks behind the longitudinal front, for derivatives to be those of a base at friction:
these differ by 1e-6 of themselves at most in four kinds of scene, where differences were off by
up to 1e-5 below 1e-6 and by their own size below 1e-11."""
AT_BORDER = 1e-7
"""Margin of Coulomb's law, width or slip rate over the largest, below which zones are about to
change."""

# Fields in the bodies (solution)

FIELD_RULE_SHARE, FINEST_FIELD_RULE = 0.1, 1e-14
"""Tolerance of their rule over that of the solution: transforms that grow like k^1/2 lose some of
it far out; and the least."""
