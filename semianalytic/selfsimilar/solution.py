"""Self-similar solutions: all fields on the interface as functions of position and time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.cut.profile import Profile
from semianalytic.cut.slot_faces import SlotFaces
from semianalytic.halfplane.stuck import stress_intensity
from semianalytic.results.answer import Arrival
from semianalytic.results.gridded import AnswerInBodies
from semianalytic.results.intervals import finite_times
from semianalytic.results.reading import Reading, first_times, self_similar_reading
from semianalytic.scene.arguments import asked_in_units
from semianalytic.scene.arrays import Array
from semianalytic.scene.contact import traction_ahead
from semianalytic.scene.errors import SceneError
from semianalytic.scene.loading import Tractions
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.shown import slips_said, zones_table
from semianalytic.selfsimilar.statistics import Statistics
from semianalytic.selfsimilar.totals import ContactTotals
from semianalytic.selfsimilar.zones.motion import (
    OpenZone,
    SlipZone,
    is_open,
    motion,
    over_slowness,
    slip_zones,
)
from semianalytic.separation.opening import NormalFields

if TYPE_CHECKING:  # imported where they are asked for, for a quick import
    from semianalytic.field.bodies import Bodies
    from semianalytic.selfsimilar.derivatives.derivative import Derivative
    from semianalytic.selfsimilar.derivatives.variation import Surroundings


@asked_in_units
@dataclass(frozen=True, eq=False)
class Solution(ContactTotals, AnswerInBodies):
    """Self-similar slip on the interface of a scene, as returned by `solve`.

    All fields broadcast over positions x > 0 [length] and times t [time]; before t = 0 they are
    those of the base state. Slip and slip rate are relative, upper minus lower side. Like every
    result that holds arrays, a solution equals only itself; compare fields.

    Attributes
    ----------
    scene : Scene
    status : str
        "converged", or a sentence on what is unreliable.
    error_estimate : float
        Estimate, meant as a bound, of the errors of

        - zone edges, relative to c_t; a zone, or a part of a zone near its edge, that slips less
          than this, relative to the largest slip rate, may be missing or have the other sense;
        - the slip rate over all positions, in L1 relative to its own L1 norm;
        - the slip rate at every point further than 0.03 c_t from zone edges and from c_R,
          relative to its largest value there, and the shear traction there, relative to itself
          plus its change plus the largest load.  Nearer the error may be larger: a shift e of an
          edge changes the square root at it by up to e^(1/2), and the logarithm at c_R has no
          largest value;
        - edges of openings, relative to c_t; the gap, relative to its largest value, in L1; its
          rate, like the slip rate; and the pressure, relative to base plus step;
        - slip, path and work of friction at every point, relative to their largest value;
        - frictional power and work of the whole contact or of a part, relative to the whole, and
          accumulated slip, relative to itself;
        - slip rate and stress intensity at the contact edge, relative to themselves.
    statistics : Statistics
    profile : Profile
        The fields over slowness, in units b = mu = 1 and `stress_unit`.
    stress_unit : float
        Unit of stress of `profile`.
    normal : NormalFields or None
        Pressure and gap over slowness, in the same units, where the contact opens.

    Examples
    --------
    >>> from semianalytic import Material, Scene, Tractions, solve
    >>> base, load = Tractions(1.0, 0.0), Tractions(0.0, 1.0)
    >>> solution = solve(Scene(Material(1.0, 1.0, 1 / 3), 1.0, base, load))
    >>> round(solution.edge_slip_rate, 6)
    0.586406
    >>> solution.slip([0.1, 0.5], t=1.0).round(4)
    array([0.2968, 0.    ])
    """

    scene: Scene
    status: str
    error_estimate: float
    statistics: Statistics
    profile: Profile
    stress_unit: float
    normal: NormalFields | None = None

    def __repr__(self) -> str:
        moving = slips_said(self.zones, self.openings)
        return f"<Solution: {moving}; {self.status}, error estimate {self.error_estimate:.1e}>"

    def _repr_html_(self) -> str:
        caption = f"{self.status}, error estimate {self.error_estimate:.1e}"
        return zones_table(self.scene, self.zones, self.openings, caption)

    def _evaluate(self, x: ArrayLike, t: ArrayLike, field: Callable[[Array], Array]) -> Array:
        """Evaluate a field over slowness, (m,) or (k, m), at x and t; it is 0 before t = 0."""
        return over_slowness(self.scene.material.shear_speed, x, t, field)

    @cached_property
    def zones(self) -> tuple[SlipZone, ...]:
        """Slip zones, from the contact edge outward."""
        return slip_zones(self.profile, self.scene.material)

    @property
    def openings(self) -> tuple[OpenZone, ...]:
        """Open parts of the contact, from the contact edge outward; there is one at most."""
        if self.normal is None:
            return ()
        zone, speed = self.normal.opening.zone, self.scene.material.shear_speed
        assert zone.left is not None
        # In slowness the left end is the faster one, hence the outer edge in velocity.
        inner = 0.0 if zone.right is None else float(speed / zone.right.v[0])
        return (OpenZone(inner, float(speed / zone.left.v[0])),)

    @cached_property
    def _motion(self) -> tuple[SlipZone, ...]:
        """Parts of the interface where the sides move along one another, in contact or open."""
        moving = self.zones
        for opening in self.openings:
            moving = motion(self.profile, moving, opening, self.scene.material.shear_speed)
        return moving

    @property
    def _one_way(self) -> tuple[tuple[float, float], ...]:
        return tuple((zone.inner, zone.outer) for zone in self._motion)

    @property
    def _rate_unit(self) -> float:
        # V of one side has the unit stress / (rho c_t); the relative slip rate is twice V.
        return 2 * self.stress_unit / self.scene.material.shear_impedance

    def slip_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the relative slip rate [length / time] at x and t; logarithmically infinite at c_R
        where slip covers it.

        Raises
        ------
        SceneError
            If a position is not positive, or x or t is not finite.
        """
        return self._rate_unit * self._evaluate(x, t, self.profile.slip_rate)

    def slip(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the relative slip [length], the time integral of `slip_rate` since t = 0.

        Raises what `slip_rate` raises.
        """
        time = np.asarray(t, dtype=float)
        return self._rate_unit * time * self._evaluate(x, t, self.profile.slip_over_time)

    def shear_traction(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the total shear traction sigma_xy [stress], base included; raises like
        `slip_rate`."""
        # The profile holds what the waves from the slot change; ahead of them the base, or the
        # traction in place behind the front of the load, acts alone.
        change = self._evaluate(x, t, self.profile.shear_change)
        return traction_ahead(self.scene, "shear", x, t) + self.stress_unit * change

    def pressure(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the contact pressure [stress], base included, 0 where open; slip does not change
        it.

        Raises what `slip_rate` raises.
        """
        change = self._evaluate(x, t, self.profile.pressure_change)
        pressure = traction_ahead(self.scene, "pressure", x, t) + self.stress_unit * change
        return np.where(is_open(self.openings, x, t), 0.0, pressure)

    def gap(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the gap of the open contact [length], 0 where closed; raises like `slip_rate`."""
        over_time = self._evaluate(x, t, self._of_gap(Profile.slip_over_time))
        gap = self._rate_unit * np.asarray(t, dtype=float) * over_time
        # Rounding may leave a negative gap near the ends of the opening.
        return np.where(is_open(self.openings, x, t), np.maximum(gap, 0.0), 0.0)

    def gap_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the rate of the gap [length / time], 0 where closed; raises like `slip_rate`.

        It is logarithmically infinite at the Rayleigh front where the contact is open there.
        """
        return self._rate_unit * self._evaluate(x, t, self._of_gap(Profile.slip_rate))

    def _of_gap(self, field: Callable[[Profile, Array], Array]) -> Callable[[Array], Array]:
        """Return a slip field of the normal problem over slowness; 0 where it is closed."""
        normal = self.normal
        return np.zeros_like if normal is None else lambda u: field(normal.profile, u)

    @cached_property
    def edge_slip_rate(self) -> float:
        """Relative slip rate at the contact edge, x -> 0+ [length / time]; 0 if it sticks."""
        return self._rate_unit * self.profile.edge_slip_rate

    def stress_intensity(self, t: ArrayLike) -> tuple[Array, Array]:
        """Return (K_I, K_II) at the contact edge at times t [stress sqrt(length)]: (3.13), (3.16).

        The pressure is K_I / sqrt(2 pi x) and the shear traction K_II / sqrt(2 pi x) near the edge;
        a slipping edge has |K_II| = f K_I. In antiplane shear the second value is K_III.
        """
        scene, t = self.scene, finite_times(t)
        unit = Tractions(1.0, 1.0)
        mode_one, sheared = stress_intensity(scene.material, unit, t, scene.shear_mode)
        pressure, factors = scene.superposition.taken_off.pressure, self.profile.fields.factors
        # K of a front that moves is M_+(0) / M_+(-p) of that of a step.
        slowness = self.profile.fields.load.slowness
        if pressure:
            pressure *= factors.m_plus_at_zero["I"] / factors.m_plus_at_load(slowness, "I")
        if self.normal is not None:
            pressure = -self.stress_unit * float(self.normal.profile.edge_intensity)
        mode_one = pressure * mode_one + 0.0  # 0 where open, not -0
        # At a slipping edge the traction is s f p, and so is its singular part.
        if self.profile.edge_slips:
            return mode_one, self.profile.panels.sense[-1] * scene.coefficient * mode_one + 0.0
        return mode_one, self.stress_unit * self.profile.edge_intensity * sheared + 0.0

    def arrival(self, x: ArrayLike, of: Arrival = "slip") -> Array:
        """Return the first time at which the sides move along one another, or come apart, at x
        [time].

        It is x over the speed of the first edge that comes by, as exact as that edge;
        `reading(x, t).arrivals` gives it with its error.

        Parameters
        ----------
        x : array
            Positions [length], positive.
        of : str
            "slip" of either sense, "forward" or "reverse" for slip towards +x or -x alone, or
            "opening".  Slip includes the motion of open parts.

        Returns
        -------
        array
            Times of the shape of x: inf where it never comes, 0 where slip is ahead of all waves.

        Raises
        ------
        SceneError
            If a position is not positive or finite, or there is no such arrival.
        """
        if of == "opening":
            return first_times(x, self.openings)
        senses = {"forward": (1,), "reverse": (-1,)}.get(of, (1, -1))
        return first_times(x, (zone for zone in self._motion if zone.sense in senses))

    def reading(self, x: ArrayLike, t: ArrayLike) -> Reading:
        """Return arrivals and fields at x until t, each with its error bar.

        Errors of edges are `error_estimate` times c_t.  Those of fields are `error_estimate` times
        the scales listed there, plus the change due to a shift of all edges by their error, so that
        they are valid near edges and at c_R as well.  All bars are inf if the solution breaks
        Coulomb's law.

        Parameters
        ----------
        x, t : arrays
            Positions [length] and times [time], which broadcast.

        Raises
        ------
        SceneError
            As `slip_rate` does.
        """
        # The scale of the shear traction is that of the largest load, the wave of a remote one too.
        base, (held, load) = self.scene.base, self.scene.superposition
        largest = max(abs(load.pressure), abs(load.shear), abs(held.shear - base.shear))
        time, gaps = np.maximum(np.asarray(t, dtype=float), 0.0), 0.0
        for part in self.openings:  # the largest gap over time, on a fine grid
            gaps = float(self.gap(np.linspace(part.inner, part.outer, 66)[1:-1], 1.0).max())
        scales = {
            "slip": self.max_slip(t),
            "slip_rate": self._rate_unit * float(self.profile.largest_rate),
            "shear_traction": largest,
            "pressure": max(base.pressure, held.pressure) + abs(load.pressure),
            "gap": gaps * time,
        }
        return self_similar_reading(self, x, t, self.scene.material.shear_speed, scales)

    @cached_property
    def _surroundings(self) -> Surroundings:
        """Neighbouring sets of zones, which all derivatives share."""
        from semianalytic.selfsimilar.derivatives.parameters import at_the_front
        from semianalytic.selfsimilar.derivatives.variation import Surroundings

        return Surroundings(at_the_front(self.profile))

    def derivative(self, name: str) -> Derivative:
        """Return the derivative of zones and fields with respect to one parameter alone.

        The conditions at the zone edges are differentiated implicitly, at about the cost of the
        solution.

        Parameters
        ----------
        name : str
            "friction", "poisson_ratio", "base_pressure", "base_shear", "load_pressure",
            "load_shear" or "viscosity" (with `Coulomb` of a viscosity).

        Returns
        -------
        Derivative
            Its `status` says where zones are about to change: it is then valid on one side only.

        Raises
        ------
        SceneError
            If there is no such parameter, or no derivative with respect to it in this scene.
        ComputationError
            If the set of zones changes at this value of the parameter.
        """
        from semianalytic.selfsimilar.derivatives.derivative import differentiated

        # `differentiated` gets plain numbers, so that its module need not import this one.
        zones = tuple((zone.inner, zone.outer, zone.sense) for zone in self.zones)
        solved = self.scene, self._surroundings, self.stress_unit
        return differentiated(solved, zones, self.status, name)

    @cached_property
    def _bodies(self) -> Bodies:
        from semianalytic.field.bodies import Bodies
        from semianalytic.selfsimilar.rated.law import on_any_panels

        fields = on_any_panels(self.profile)
        # Transforms that grow like k^(1/2) lose some digits far out: the bodies use a finer rule.
        tolerance = max(0.1 * fields.rule.tolerance, 1e-14)
        opened = None if self.normal is None else self.normal.profile.fields
        return Bodies(self.scene, fields, opened, self.stress_unit, tolerance)

    @cached_property
    def _slot_faces(self) -> SlotFaces:
        return SlotFaces(self.profile.fields)

    def slot_velocity(self, x: ArrayLike, t: ArrayLike) -> tuple[Array, Array]:
        """Return the particle velocity (v_x, v_y) [length / time] of the upper slot face at x < 0.

        It is logarithmically infinite at the Rayleigh front. In antiplane shear the first is v_z.
        An incident wave is part of it.

        Raises
        ------
        SceneError
            If a position is not negative, or x or t is not finite.
        """
        x = np.asarray(x, dtype=float)
        if np.any(x >= 0):
            raise SceneError("the slot is x < 0; ask for negative positions.")
        # The closed form below is that of a step on the slot; other loads use the whole field.
        if not isinstance(self.scene.load, Tractions):
            rows = self.velocity(x, 0.0, t)
            return rows[-1 if self.scene.antiplane else 0], rows[1]
        # The velocity of one face has half the unit of the relative slip rate.
        both = self._evaluate(-x, t, lambda v: np.stack(self._slot_faces.velocity(v)))
        tangential, normal = self._rate_unit / 2 * both
        return tangential, normal
