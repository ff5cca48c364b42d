"""The problem sheets: scenes, a line without a slot, a wave at an angle, and interfaces."""

from __future__ import annotations

import difflib
from collections.abc import Mapping

from compare.benchmarks.interfaces.sheets import INTERFACE_SHEETS
from compare.benchmarks.sheet import OPENING, SLIPPING, Sheet
from semianalytic.scene.errors import SceneError

_SHEETS = (
    Sheet(
        "stuck",
        "A slot struck from afar, friction that holds",
        "diffraction at the edge: both tractions are singular there and nothing may slip",
        (*SLIPPING, "pressure"),
        arrival="",
        note="Slip and slip rate are zero; errors of them are over those that the load would make "
        "on a free surface.",
    ),
    Sheet(
        "preloaded",
        "Supershear daughter",
        "slip from the edge behind the Rayleigh wave, a stick gap, and a daughter zone across the "
        "shear wave",
        SLIPPING,
        note="Slip heals between the two zones.  Of the daughter, hardly faster than the shear "
        "wave, the slip rate is at most a 24th of that at the edge.",
    ),
    Sheet(
        "remote-shock",
        "A shock from afar, friction just low enough",
        "the same two zones under a pressure that varies and is singular at the edge",
        (*SLIPPING, "pressure"),
    ),
    Sheet(
        "auxetic",
        "Reverse slip around the Rayleigh front",
        "slip that changes its sense twice; slip rate has a logarithm at the Rayleigh front",
        SLIPPING,
        note="Poisson ratio -0.5: a code must not take it for positive.",
    ),
    Sheet(
        "viscous",
        "A viscous film",
        "strength that grows with slip rate: one zone across the Rayleigh front",
        SLIPPING,
        note="Strength is friction times pressure plus 0.1 mu/c_t times slip rate.",
    ),
    Sheet(
        "antiplane",
        "Antiplane shear",
        "one zone that grows from the edge, all of it in closed form",
        SLIPPING,
        note="In the place of Kostrov's problem, and not that problem: his crack of 1966 "
        "(J. Appl. Math. Mech. 30, 1241) runs at a speed that is given, with a singular edge; here "
        "friction gives the speed, c_t / (1 + f P_b / Q_0)^2 = 4/9 c_t, at which the edge carries "
        "no singularity.",
    ),
    Sheet(
        "lift-off",
        "The contact opens from its edge",
        "separation: up to 3/16 c_t, parting smoothly",
        ("pressure",),
        arrival=OPENING,
        note="Nothing slips, for there is no shear.",
    ),
    Sheet(
        "lift-off-shear",
        "Slip ahead of an opening",
        "separation with slip: friction grows from nothing at the end of the opening",
        (*SLIPPING, "pressure"),
        note="Where the contact is open, slip is the difference of the tangential displacements.",
    ),
    Sheet(
        "tap",
        "Separation ahead of a tap",
        "a contact that opens ahead of the Rayleigh wave and closes again behind it",
        ("pressure",),
        arrival=OPENING,
        note="Nothing slips, for there is no shear.",
    ),
    Sheet(
        "pulse",
        "A pulse of shear",
        "a load that goes off again, at 0.4 T: slip slows down, heals, and turns back at the edge",
        SLIPPING,
        note="Not self-similar: the answer is marched, to as many digits as are sure.",
    ),
)

SHEETS: Mapping[str, Sheet] = {sheet.name: sheet for sheet in _SHEETS}
LINE_SHEETS: Mapping[str, Sheet] = {
    "whole-line-patch": Sheet(
        "whole-line-patch",
        "Slip around an over-stressed patch",
        "spontaneous edges without a slot: slip spreads smoothly to both sides of a patch whose "
        "ends advance, at a speed that friction decides",
        SLIPPING,
        note="Slip rate has a logarithm at the ends of the patch.  The answer is even in x.",
    )
}
"""Problems without a slot, which have no tolerance classes: our own codes do not take them."""
FRONT_SHEETS: Mapping[str, Sheet] = {
    "incident-sv": Sheet(
        "incident-sv",
        "An SV wave at an angle",
        "a load whose front moves: the wave meets the contact first, adds pressure and shear to "
        "it, and both are singular at the edge, which slips against the wave",
        (*SLIPPING, "pressure"),
        note="The wave has passed all of the contact by t = 0, so that the contact carries it from "
        "the outset. With the stress S = rho c_t v_0 of the wave, 0.3 or 3 MPa, and theta = -20 "
        "degrees, P_0 = -S sin(2 theta) and Q_0 = -S cos(2 theta).",
    )
}
"""Problems with a slot and a load with a moving front, without measured tolerance classes."""
PAIR_SHEETS: Mapping[str, Sheet] = {
    "pair-slip": Sheet(
        "pair-slip",
        "Slip between two different bodies",
        "slip that changes the pressure it feels: both tractions of the contact are unknown at "
        "once, and their edge turns as it grows",
        (*SLIPPING, "pressure"),
        note="Friction is below the threshold above which waves grow along this interface however "
        "fine the grid, for slip of either sense, so that a delay is neither needed nor wanted.",
    ),
    "pair-opening": Sheet(
        "pair-opening",
        "Two different bodies that part and slip",
        "separation and slip that drive each other: the contact opens from its edge, and slips "
        "ahead of the opening under a pressure that falls to nothing there",
        (*SLIPPING, "pressure"),
        note="Where the contact is open, slip is the difference of the tangential displacements.",
    ),
}
"""Problems of two different bodies, whose classes are those of our finite elements too."""
RATED_SHEETS: Mapping[str, Sheet] = {**SHEETS, **PAIR_SHEETS, **INTERFACE_SHEETS}
"""Problems with tolerance classes."""
ALL_SHEETS: Mapping[str, Sheet] = {
    **SHEETS,
    **LINE_SHEETS,
    **FRONT_SHEETS,
    **PAIR_SHEETS,
    **INTERFACE_SHEETS,
}


def find_sheet(name: str) -> Sheet:
    """Sheet of a name.

    Raises
    ------
    SceneError
        If there is none.
    """
    if name in ALL_SHEETS:
        return ALL_SHEETS[name]
    close = difflib.get_close_matches(name, ALL_SHEETS, n=1, cutoff=0.5)
    hint = f"did you mean {close[0]}?" if close else f"choose {', '.join(ALL_SHEETS)}."
    raise SceneError(f"There is no benchmark called {name!r}; {hint}")
