"""The sheets of interfaces: what is asked, and the interface that `run` and `fem` take for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from compare.benchmarks.sheet import SLIPPING, Sheet
from semianalytic import Interface
from semianalytic.interface.files import parsed
from semianalytic.interface.named import NAMED_INTERFACES


@dataclass(frozen=True)
class InterfaceSheet(Sheet):
    """A problem of an interface, whose answer is the limit of the two finest grids.

    Attributes
    ----------
    statement : str
        The problem in words.
    numbers : tuple of (str, str)
        Names and values of all numbers, with units.
    text : str
        The interface as a file that `run` reads.
    units : str
        The system of units.
    places : tuple of float
        Stations [length].
    step : float
        Distance of the times at which the answer is given [time].
    breadth : float
        Length over which cells are counted [length].
    breadth_words : str
        The same in words.
    nodes : int
        Nodes of the finest grid.
    order : int
        Order at which runs converge, so that their limit is f + (f - f_coarse) / (2^order - 1).
    level : float
        Slip rate whose first time is the arrival [length / time].
    friction : str
        Friction in symbols and numbers.
    """

    statement: str = ""
    numbers: tuple[tuple[str, str], ...] = ()
    text: str = ""
    units: str = ""
    places: tuple[float, ...] = ()
    step: float = 0.0
    breadth: float = 1.0
    breadth_words: str = ""
    nodes: int = 0
    order: int = 1
    level: float = 0.0
    friction: str = ""

    @cached_property
    def _file(self) -> Any:
        return parsed(self.text, self.name, Path())

    @property
    def interface(self) -> Interface:
        """The interface of the problem."""
        described: Interface = self._file.interface
        return described

    @property
    def options(self) -> dict[str, Any]:
        """Options of `run` that the problem needs: the shortest step over the node distance."""
        given = self._file.options
        return {name: given[name] for name in ("step_ratio",) if name in given}

    @property
    def friction_words(self) -> str:
        """Poisson ratio and friction, for figures."""
        return f"ν = {self.interface.material.poisson_ratio:.3g}, {self.friction}"

    @property
    def document(self) -> dict[str, str]:
        """The problem for JSON: the file that `run` reads."""
        return {"interface": self.text.strip()}

    @property
    def is_interface(self) -> bool:
        """Whether the problem is an interface: it is."""
        return True

    @property
    def is_line(self) -> bool:
        """Whether the problem is a whole line under Coulomb friction: it is not."""
        return False

    @property
    def is_marched(self) -> bool:
        """Whether the answer has an error estimate: it has."""
        return True

    @property
    def stations(self) -> tuple[float, ...]:
        """Positions of the stations [length]."""
        return self.places

    @property
    def end_time(self) -> float:
        """T [time]."""
        return float(self._file.end_time)

    @property
    def times(self) -> tuple[float, ...]:
        """Times of the answer [time]."""
        count = round(self.end_time / self.step)
        return tuple((self.end_time * (np.arange(1, count + 1) / count)).tolist())

    @property
    def extent(self) -> float:
        """Length over which cells are counted [length]."""
        return self.breadth

    @property
    def crossing(self) -> float:
        """Time in which shear waves cross `extent` [time]."""
        return self.breadth / self.interface.material.shear_speed

    def nodes_of(self, cells: int) -> int:
        """Return the nodes of a period with so many cells over `extent`."""
        return round(self.interface.length * cells / self.breadth)


SI = "SI"
"""`InterfaceSheet.units` of problems in metres, seconds, kilograms and pascals."""
_CRUST = (
    ("shear modulus μ", "32.03812032 GPa"),
    ("density ρ", "2670 kg/m^3"),
    ("Poisson ratio ν", "0.250022 (c_t = 3464 m/s, c_l = 6000 m/s)"),
)
_FACES = (
    "Slip V and its rate are those of the upper face less the lower one; tractions are the whole "
    "ones."
)
_TPV205 = '''
summary = "SCEC TPV205 in two dimensions: slip weakening with patches of high and low shear"
length = 96e3
pressure = 120e6
shear = """
70e6 + 5.8e6 * (abs(x) < 1.5e3) + 5.8e6 * (abs(x) <= 1.5e3)
+ 4e6 * (abs(x + 7.5e3) < 1.5e3) + 4e6 * (abs(x + 7.5e3) <= 1.5e3)
- 4e6 * (abs(x - 7.5e3) < 1.5e3) - 4e6 * (abs(x - 7.5e3) <= 1.5e3)"""
''' + NAMED_INTERFACES["tpv205"].partition('"""\n')[2].partition('"""\n')[2]
"""As the named interface, but nodes at the ends of patches have the mean of both sides, so that the
limit of fine grids is approached at first order with a small constant."""

_SHEETS = (
    InterfaceSheet(
        "tpv101",
        "Rate-and-state rupture, SCEC TPV101 in two dimensions",
        "friction with a state: slip rates from 1e-12 to 17 m/s, a smooth nucleation, and a "
        "rupture that ends where friction strengthens",
        SLIPPING,
        note="As UGUCA ran it. The line is periodic, and waves of the neighbouring periods are "
        "part of the problem.",
        statement="Two half-planes of one elastic solid, y > 0 and y < 0, touch along all of "
        "y = 0; everything is periodic in x with the period L, in plane strain. The strength is "
        "a p arcsinh[V/(2 V_0) exp((f_0 + b ln(V_0 θ/D))/a)], and the state obeys the ageing law "
        "dθ/dt = 1 - V θ/D. With |x| in km, a = 0.008 for |x| < 15, a = 0.016 for |x| > 18, and "
        "a = 0.008 + 0.004 [1 - tanh(3/(|x| - 18) + 3/(|x| - 15))] between. At t = 0 the interface "
        "slips at the rate V_i everywhere, under the shear Q_b: this gives θ. From then on an "
        "interface without slip would carry the shear Q_b + Q_0 F(x) G(t), F = exp[x²/(x² - R²)] "
        f"for |x| < R and 0 beyond, G = exp[(t - t_0)²/(t (t - 2 t_0))] for t < t_0, then 1. "
        f"{_FACES}",
        numbers=(
            *_CRUST,
            ("pressure p", "120 MPa"),
            ("shear of the base Q_b", "75 MPa"),
            ("shear of the load Q_0", "25 MPa"),
            ("R, t_0", "3 km, 1 s"),
            ("b, f_0", "0.012, 0.6"),
            ("V_0, V_i", "1e-6 m/s, 1e-12 m/s"),
            ("length D", "0.02 m"),
            ("period L", "72 km"),
            ("end T", "15 s"),
        ),
        text=NAMED_INTERFACES["tpv101"],
        units=SI,
        places=(0.0, 4500.0, 9000.0, 12000.0, 15000.0),
        step=0.05,
        breadth=10e3,
        breadth_words="10 km",
        nodes=5760,
        order=2,
        level=1e-3,
        friction="f = 0.6 at 1 µm/s, a = 0.008, b = 0.012",
    ),
    InterfaceSheet(
        "tpv205",
        "Slip weakening with patches, SCEC TPV205 in two dimensions",
        "friction that weakens with slip: a rupture that starts at once, passes a patch of high "
        "and a patch of low shear, overtakes shear waves on one side, and stops at barriers",
        SLIPPING,
        note="No wave of a neighbouring period of 96 km reaches a station until T, so that the "
        "line may as well be infinite. At x = 0 slip begins at once, and nothing is timed.",
        statement="Two half-planes of one elastic solid, y > 0 and y < 0, touch along all of "
        "y = 0, in plane strain. The strength is f p with a friction f that falls linearly with "
        "slip from f_s to f_d, which it reaches at a slip of D and keeps. There is no slip beyond "
        "|x| = W. Before t = 0 nothing moves, and the shear is 70 MPa, but 81.6 MPa for "
        "|x| < 1.5 km, 78 MPa for |x + 7.5 km| < 1.5 km and 62 MPa for |x - 7.5 km| < 1.5 km; the "
        f"first exceeds the strength, 81.24 MPa, and slips from t = 0 on. {_FACES}",
        numbers=(
            *_CRUST,
            ("pressure p", "120 MPa"),
            ("friction f_s, f_d", "0.677, 0.525"),
            ("slip D", "0.4 m"),
            ("W", "15 km"),
            ("end T", "12 s"),
        ),
        text=_TPV205,
        units=SI,
        places=(-12000.0, -7500.0, -4500.0, 0.0, 4500.0, 7500.0, 12000.0),
        step=0.05,
        breadth=10e3,
        breadth_words="10 km",
        nodes=7680,
        order=1,
        level=1e-3,
        friction="f = 0.677 to 0.525",
    ),
    InterfaceSheet(
        "two-slots",
        "A contact between two slots",
        "contacts of finite width: slip enters from four edges, and two zones meet in the middle",
        SLIPPING,
        note="Until t = 2.1 c_t/c_l = 1.21 the answer at x = 3.1 is that of one slot that is "
        "infinitely long, which is known exactly. The answer is even in x, and the line may be "
        "taken as infinite.",
        statement="Two half-planes of one elastic solid, y > 0 and y < 0, touch on |x| < 1 and on "
        "|x| > 3; between lie two open slots. On the contacts Coulomb's law holds, strength f p. "
        "Everything is at rest under the pressure p, without shear; from t = 0 on the faces of "
        "both slots receive the change of shear -Q_0. Shear and slip act along x. Nothing changes "
        f"the pressure. {_FACES}",
        numbers=(
            ("shear modulus μ, density ρ, c_t", "1"),
            ("half the width of the middle contact", "1"),
            ("Poisson ratio ν", "0.25"),
            ("pressure p", "1"),
            ("friction f", "0.3"),
            ("shear Q_0", "1"),
            ("end T", "3"),
        ),
        text=NAMED_INTERFACES["two-slots"],
        units="mu = rho = c_t = 1, half the width of the middle contact = 1",
        places=(0.0, 0.3, 0.6, 0.9, 3.1, 3.5, 4.0),
        step=0.02,
        breadth=2.0,
        breadth_words="2, the width of the middle contact",
        nodes=9600,
        order=1,
        level=2e-3,
        friction="f = 0.3",
    ),
)
INTERFACE_SHEETS: Mapping[str, InterfaceSheet] = {sheet.name: sheet for sheet in _SHEETS}
"""Problems of interfaces, in their own units and with their own stations."""
