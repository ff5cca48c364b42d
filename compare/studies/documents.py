"""Results of studies as plain dictionaries with units, for JSON.

Studies are dimensionless, so most units are "1" or a product of scales such as "V_0 c_t T^2".
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from compare.studies.article.claims import Claim
    from compare.studies.article.study import Article
    from compare.studies.dissimilar.study import GrowthResults
    from compare.studies.regimes.figures import RegimeResults
    from compare.studies.supershear.study import RuptureResults


def regimes_document(results: RegimeResults) -> dict[str, Any]:
    """Return the number of points of each regime, and the traced curves; the maps are in files."""
    return {
        "regimes": {
            loading: dict(Counter(point.regime for point in points))
            for loading, points in results.points.items()
        },
        "boundaries": [asdict(point) for point in results.curves],
        "units": {"boundaries": {"poisson_ratio": "1", "log10_chi": "1"}},
    }


def growth_document(results: GrowthResults) -> dict[str, Any]:
    """Curves of the map of growing waves, and pairs that are met; the map itself is a file."""
    growth = {"growth": "%", "friction": "1", "velocity": "c_t of the upper body"}
    return {
        "thresholds": [asdict(one) for one in results.thresholds],
        "named": [asdict(one) for one in results.named],
        "units": {"thresholds": "1", "named": growth},
    }


def ruptures_document(results: RuptureResults) -> dict[str, Any]:
    """Return where each rupture overtakes shear waves; the map of its speeds is a file."""
    units = {"strength": "1", "nodes": "1 / L_c", "transition": "L_c", "farthest": "L_c"}
    return {
        "transitions": [asdict(one) for one in results.transitions],
        "units": {"transitions": units},
    }


def stability_document(studies: Mapping[str, Mapping[str, Sequence[Any]]]) -> dict[str, Any]:
    """Return the tables of each study that was run; `value` and `error` are relative."""
    return {
        "studies": {
            name: {table: [asdict(row) for row in rows] for table, rows in tables.items()}
            for name, tables in studies.items()
        },
        "units": {"studies": "1"},
    }


def article_document(article: Article) -> dict[str, Any]:
    """Return claims and verdicts of all methods, and how far solver and simulation differ."""
    return {
        "claims": _claims(article.claims),
        "disagreement": article.disagreement,
        "units": {"disagreement": "V_0"},
    }


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
