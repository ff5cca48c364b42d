"""A fit as plain dictionaries with units, for JSON and tables."""

from __future__ import annotations

from typing import Any

import numpy as np

from compare.comparison.documents import SCENE_DIMENSIONS, units_document
from semianalytic.inversion.fitted import Fit
from semianalytic.inversion.priors import Normal
from semianalytic.inversion.quoted import QUOTED
from semianalytic.inversion.unknowns import is_of_setup
from semianalytic.parameters.numbers import numbers_of
from semianalytic.results.reading import Measured
from semianalytic.scene.given.documents import scene_document

WELL = 3.0
"""Standard deviations that chi2 may exceed its freedom by in a fit as good as noise allows."""

BY_PRIOR = 0.9
"""Ratio of the standard error to that of the prior above which the data add nothing."""


def dimension(name: str, scene: object) -> str:
    """Return the physical dimension of an unknown of a scene or interface."""
    if is_of_setup(name):
        return {"t0": "time", "x0": "length"}.get(name, "1")
    known = numbers_of(scene)
    return known[name].dimension if name in known else "1"


def fit_document(fit: Fit) -> dict[str, Any]:
    """Return a fit as dictionaries, lists, text and numbers."""
    rows = zip(fit.parameters, fit.values, fit.standard_errors, fit.interval, strict=True)
    document: dict[str, Any] = {
        "scene": scene_document(fit.scene),
        "parameters": {
            name: {
                "value": float(value),
                "standard_error": float(error),
                "from": float(ends[0]),
                "to": float(ends[1]),
            }
            for name, value, error, ends in rows
        },
        "covariance": fit.covariance.tolist(),
        "correlation": fit.correlation.tolist(),
        "rupture": {
            "x": fit.quoted.x.tolist(),
            **{name: quoted_document(getattr(fit.quoted, name)) for name in QUOTED},
        },
        "chi2": fit.chi2,
        "freedom": fit.freedom,
        "unconstrained": list(fit.unconstrained),
        "known_by_prior": list(known_by_prior(fit)),
        "minima": [
            {"values": values.tolist(), "chi2": float(chi2)}
            for values, chi2 in zip(fit.minima, fit.chi2_of_minima, strict=True)
        ],
        "gauges": [
            {
                "name": gauge.name,
                "quantity": gauge.quantity,
                "x": gauge.x,
                "y": gauge.y,
                "samples": len(gauge.t),
                "chi2": float(np.sum((residual / gauge.noise) ** 2)),
            }
            for gauge, residual in zip(fit.gauges, fit.residuals, strict=True)
        ],
        "derivative_error": fit.derivative_error,
        "solutions": fit.solutions,
        "status": fit.status,
        "misfit": misfit_sentence(fit),
    }
    units = {name: dimension(name, fit.scene) for name in fit.parameters}
    dimensions = {
        "scene": SCENE_DIMENSIONS,
        "parameters": units,
        "rupture": {"x": "length", **QUOTED},
        "chi2": "1",
        "gauges": {"x": "length", "y": "length", "chi2": "1"},
        "derivative_error": "1",
    }
    document["units"] = units_document(document, dimensions, fit.scene)
    return document


def quoted_document(found: Measured) -> dict[str, list[float]]:
    """Return what is quoted at several places, and the ends of one standard error."""
    ends = {"from": found.value - found.error, "to": found.value + found.error}
    return {name: row.tolist() for name, row in {"value": found.value, **ends}.items()}


def misfit_sentence(fit: Fit) -> str:
    """Say how large the misfits are compared with the stated noise."""
    if not fit.freedom:
        return "there are no more samples than parameters, so the misfit has no meaning"
    share, spread = fit.chi2 / fit.freedom, (2 / fit.freedom) ** 0.5
    if share > 1 + WELL * spread:
        return (
            f"misfits are {share**0.5:.2g} times what the noise allows: the noise is larger "
            "than stated, or the scene differs from that of the records; the errors are too small "
            "by at least this factor"
        )
    if share < 1 - WELL * spread:
        return f"misfits are {share**0.5:.2g} times the noise, which is smaller than stated"
    return "misfits are as large as the noise"


def known_by_prior(fit: Fit) -> tuple[str, ...]:
    """Return the parameters of which the data say next to nothing beyond their prior."""
    errors = dict(zip(fit.parameters, fit.standard_errors, strict=True))
    priors = fit.trials.priors.items()
    return tuple(
        name
        for name, prior in priors
        if isinstance(prior, Normal) and errors[name] > BY_PRIOR * prior.sd
    )
