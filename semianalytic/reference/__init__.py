"""References for verification: exact solutions in closed form.

They do not use the solvers, only the Rayleigh function, its factors, compliances and quadrature.
Every slip rate is relative, both sides, in the units of the scene.

Closed forms, at velocities x/t (chi = f P / Q_0):

- `edge_speed_under_shear_step`, `slip_rate_under_shear_step`: one zone that grows from the contact
  edge under a step of shear, large chi;
- `slip_rate_under_remote_shock`: slip everywhere under a sudden remote load, chi <= 1;
- `slip_rate_without_friction`: Lamb's surface velocity under a step of shear, chi = 0;
- `antiplane_edge_speed`, `antiplane_slip_rate`, `antiplane_slip`, `antiplane_traction`,
  `antiplane_edge_intensity`: the zone under a step of antiplane shear, at every chi;
- `viscous_edge_speed`, `viscous_slip_rate`: one zone where strength grows with slip rate, in plane
  slower than the Rayleigh wave, or antiplane;
- `static_zone`: the slip zone of a slot that is loaded slowly, a `StaticZone`;
- `edge_speed_of_opening`, `gap_rate_of_opening`: the contact opens from its edge, under an extra
  pressure on the slot faces;
- `detached_opening`: it opens around the Rayleigh front, under a sudden pressure on a small base, a
  `DetachedOpening`;
- `prescribed_crack`: a crack that grows from a point at a given speed, Kostrov's, Burridge's and
  Broberg's, a `PrescribedCrack`;
- `weertman_pulse`: a pulse of uniform slip along two different solids, a `WeertmanPulse`.
"""

from semianalytic.reference.antiplane import (
    antiplane_edge_intensity,
    antiplane_edge_speed,
    antiplane_slip,
    antiplane_slip_rate,
    antiplane_traction,
)
from semianalytic.reference.closed_forms import (
    StaticZone,
    edge_speed_under_shear_step,
    slip_rate_under_remote_shock,
    slip_rate_under_shear_step,
    slip_rate_without_friction,
    static_zone,
)
from semianalytic.reference.openings import (
    DetachedOpening,
    detached_opening,
    edge_speed_of_opening,
    gap_rate_of_opening,
)
from semianalytic.reference.prescribed_crack import PrescribedCrack, prescribed_crack
from semianalytic.reference.viscous_zone import viscous_edge_speed, viscous_slip_rate
from semianalytic.reference.weertman import WeertmanPulse, weertman_pulse
from semianalytic.scene.arguments import checking_functions

__all__ = [
    "DetachedOpening",
    "PrescribedCrack",
    "StaticZone",
    "WeertmanPulse",
    "antiplane_edge_intensity",
    "antiplane_edge_speed",
    "antiplane_slip",
    "antiplane_slip_rate",
    "antiplane_traction",
    "detached_opening",
    "edge_speed_of_opening",
    "edge_speed_under_shear_step",
    "gap_rate_of_opening",
    "prescribed_crack",
    "slip_rate_under_remote_shock",
    "slip_rate_under_shear_step",
    "slip_rate_without_friction",
    "static_zone",
    "viscous_edge_speed",
    "viscous_slip_rate",
    "weertman_pulse",
]
checking_functions(globals())
del checking_functions
