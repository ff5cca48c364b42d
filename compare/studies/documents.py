"""Results of studies as plain dictionaries with units, for JSON.

Studies are dimensionless, so most units are "1" or a product of scales such as "V_0 c_t T^2".
Measurements of the computer are in "s" and "MB".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from semianalytic.scene.given.documents import scene_document

if TYPE_CHECKING:
    from compare.studies.article.claims import Claim
    from compare.studies.chart.points import Point
    from compare.studies.evidence.study import Evidence
    from compare.studies.wear import WearRow

_SCENE = {"poisson_ratio": "1", "chi": "1"}
_ERRORS = ("error", "edge_error", "reference_error", "reference_edge_error")


def _claims(claims: Sequence[Claim]) -> list[dict[str, Any]]:
    return [
        {
            "section": claim.section,
            "claim": claim.text,
            "base": claim.base,
            "verdicts": {method: asdict(one) for method, one in claim.verdicts.items()},
        }
        for claim in claims
    ]


def chart_document(points: Sequence[Point]) -> dict[str, Any]:
    """Return all points, and the power of time by which errors fall, by scene and method."""
    from compare.studies.chart.figure import slopes

    return {
        "points": [asdict(point) for point in points],
        "slopes": slopes(points),
        "units": {
            "points": {"setup": "s", "solving": "s", "memory": "MB", **dict.fromkeys(_ERRORS, "1")},
            "slopes": "1",
        },
    }


def wear_document(rows: Sequence[WearRow]) -> dict[str, Any]:
    """Return the wear of each transient, and the friction at which each load gives most work."""
    from compare.studies.wear import most_of

    work = {"frictional_work": "Q_0 V_0 c_t T^2"}
    return {
        "rows": [asdict(row) for row in rows],
        "most": [asdict(row) for row in most_of(rows)],
        "units": {
            "rows": {
                **_SCENE,
                "accumulated_slip": "V_0 c_t T^2",
                **work,
                "slipped_length": "c_t T",
            },
            "most": {**_SCENE, **work},
        },
    }


def evidence_document(evidence: Evidence) -> dict[str, Any]:
    """Return verdicts of all scenes, closed forms and claims of the evidence page."""
    return {
        "verdict": evidence.verdict,
        "counts": evidence.counts,
        "scenes": [
            {
                "scene": one.label,
                "parameters": scene_document(one.scene),
                "verdict": one.verdict if one.judgements else None,
                "counts": one.counts,
                "methods": list(one.methods),
                "obstacle": one.obstacle,
            }
            for one in evidence.scenes
        ],
        "closed_forms": [asdict(one) for one in evidence.closed_forms],
        "claims": _claims(evidence.claims),
        "stamp": evidence.stamp,
        "seconds": evidence.seconds,
        "units": {
            "closed_forms": {"errors": "1", "edge": "c_t", "solved_edge": "c_t"},
            "seconds": "s",
        },
    }
