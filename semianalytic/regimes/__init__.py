"""Slip regimes and their boundaries: thresholds in friction and Poisson ratio, reverse slip.

`regime` names the regime of a solution, a `Regime`.

Two loadings of unit shear (`Loading`, `scene_of`): "preload" steps shear alone, under a pressure
P_b = 1 that was there before; "remote" is a sudden uniform load of pressure P_0 = 1 and shear.
Thresholds are values of the friction coefficient chi, which is dimensionless in both.

- `edge_threshold`: below it the contact edge slips (remote), `edge_threshold_alone` on an otherwise
  stuck interface, sqrt(b/a) (3.17)-(3.19);
- `nucleation`: below it the interface slips at the shear front, `front_threshold_stuck` on an
  otherwise stuck one (remote); `crossing_poisson_ratio` is where that comes first;
- `opening_threshold`: base over step of pressure below which the contact opens ahead of the step;
- `stuck_threshold`: above both the interface is fully stuck (remote);
- `gap_threshold`: below it the stick gap at c_R is narrower than double precision resolves;
- `viscous_closing`: below it slip covers c_R under viscous friction, `closing_limit` where that is
  strong, and for no viscosity below `closing_poisson_ratio`;
- `reverse_threshold`: below it some of the interface slips backward (preload),
  `log_narrow_reverse_threshold` in closed form for narrow strips;
  `log_frictionless_half_width` is how wide they are at chi = 0.

Traced on a single zone from the contact edge: `one_zone`, `OneZone`, `past_rayleigh`; the logarithm
of its slip rate at c_R: `rayleigh_logarithm`, `RayleighLogarithm`.
"""

from semianalytic.regimes.classification import Regime, regime, stuck_threshold
from semianalytic.regimes.reverse_slip import (
    log_frictionless_half_width,
    log_narrow_reverse_threshold,
    reverse_threshold,
)
from semianalytic.regimes.thresholds import (
    Loading,
    OneZone,
    RayleighLogarithm,
    closing_limit,
    closing_poisson_ratio,
    crossing_poisson_ratio,
    edge_threshold,
    edge_threshold_alone,
    front_threshold_stuck,
    gap_threshold,
    nucleation,
    one_zone,
    opening_threshold,
    past_rayleigh,
    rayleigh_logarithm,
    scene_of,
    viscous_closing,
)
from semianalytic.scene.arguments import checking_functions

__all__ = [
    "Loading",
    "OneZone",
    "RayleighLogarithm",
    "Regime",
    "closing_limit",
    "closing_poisson_ratio",
    "crossing_poisson_ratio",
    "edge_threshold",
    "edge_threshold_alone",
    "front_threshold_stuck",
    "gap_threshold",
    "log_frictionless_half_width",
    "log_narrow_reverse_threshold",
    "nucleation",
    "one_zone",
    "opening_threshold",
    "past_rayleigh",
    "rayleigh_logarithm",
    "regime",
    "reverse_threshold",
    "scene_of",
    "stuck_threshold",
    "viscous_closing",
]
checking_functions(globals())
del checking_functions
