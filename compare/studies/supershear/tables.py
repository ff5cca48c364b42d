"""Where ruptures overtake shear waves, on two grids: the table of docs/engine.md.

``python -m compare.studies.supershear.tables transitions --csv docs/data`` takes six minutes.
"""

from __future__ import annotations

from dataclasses import dataclass

from compare.studies.supershear.points import transition_point
from compare.studies.tables import Study, run_studies

DISTANCES = {0.8: 12.0, 0.9: 16.0, 1.0: 21.0, 1.1: 28.0, 1.2: 38.0, 1.3: 54.0}
"""How far to follow the rupture of each S [L_c]: a fifth beyond its transition."""
_COARSE, _FINE = 32, 64


@dataclass(frozen=True)
class TransitionRow:
    """Transition of a rupture to supershear [L_c] on two grids, of 32 and 64 nodes per L_c."""

    strength: float
    coarse: float
    fine: float
    difference: float


def transition_rows() -> list[TransitionRow]:
    """Follow each rupture on both grids."""
    rows = []
    for strength, farthest in DISTANCES.items():
        coarse, fine = (
            transition_point(strength, nodes, farthest).transition for nodes in (_COARSE, _FINE)
        )
        rows.append(TransitionRow(strength, coarse, fine, abs(coarse / fine - 1)))
    return rows


STUDIES: dict[str, Study] = {"transitions": transition_rows}

if __name__ == "__main__":
    raise SystemExit(run_studies("compare.studies.supershear.tables", "supershear", STUDIES))
