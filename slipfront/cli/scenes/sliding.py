"""``slipfront sliding``: whether friction between two bodies has an answer, before any scene."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

import typer
from rich.console import Console

from compare.output.printed import PrintedTable
from semianalytic import Material, sliding_stability
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.solids import solids
from semianalytic.scene.tables.units import si_size
from semianalytic.scene.units import InSI, measure
from slipfront.cli.options import AsJson, measured_option
from slipfront.cli.terminal import print_json

_BODY = "G,RHO,NU"
_KINDS = {"shear modulus": "stress", "density": "mass / length^3", "Poisson ratio": "1"}
_UNITS = {
    "waves": {"growth": "length / time", "velocity": "length / time", "per_wavelength": "1"},
    **dict.fromkeys(("generalised_rayleigh_speed", "stoneley_speed"), "length / time"),
    **dict.fromkeys(
        ("friction", "dundurs", "threshold_with", "threshold_against", "delayed_growth"), "1"
    ),
}


def sliding(
    upper: Annotated[
        str,
        typer.Option(
            metavar=_BODY,
            help="Shear modulus, density, Poisson ratio of the upper body, such as "
            "12GPa,2300kg/m3,0.25, or a solid known by name, such as steel.",
        ),
    ],
    lower: Annotated[str, typer.Option(metavar=_BODY, help="The same for the lower body.")],
    friction: Annotated[float, measured_option("1", "Coulomb friction coefficient.")],
    as_json: AsJson = False,
) -> None:
    """Find whether and how fast waves grow while two bodies slide, and above which friction.

    For example slipfront sliding --upper 12e9,2300,0.25 --lower 30e9,2700,0.25 --friction 0.4, in
    any one system of units, or with units.
    """
    numbers = {name: _numbers(name, text) for name, text in (("upper", upper), ("lower", lower))}
    sized = [isinstance(number, InSI) for given in numbers.values() for number in given[:2]]
    if any(sized) and not all(sized):
        raise SceneError(
            "--upper and --lower must have units at all moduli and densities or at none."
        )
    bodies = _body("upper", numbers["upper"]), _body("lower", numbers["lower"])
    known = sliding_stability(*bodies, friction)
    if as_json:
        document = asdict(known) | {"well_posed": known.well_posed, "verdict": known.verdict}
        print_json("sliding", document | {"units": _UNITS})
        return
    velocity = " m/s" if any(sized) else ""
    table = PrintedTable("quantity", "value", title="Sliding on one another")
    table.add_row("f above which waves grow with the upper body", f"{known.threshold_with:.6g}")
    table.add_row("f above which waves grow against it", f"{known.threshold_against:.6g}")
    for name, speed in (
        ("generalised Rayleigh wave", known.generalised_rayleigh_speed),
        ("Stoneley wave", known.stoneley_speed),
    ):
        shown_speed = "there is none" if speed is None else f"{speed:.6g}{velocity}"
        table.add_row(f"speed of a {name}", shown_speed)
    table.add_row("Dundurs' beta", f"{known.dundurs:.6g}")
    for wave in known.waves:
        grows = f"{100 * (wave.per_wavelength - 1):.4g} % over a wavelength"
        table.add_row(f"wave at {wave.velocity:+.6g}{velocity}", f"grows by {grows}")
    Console().print(table)
    Console().print(known.verdict, highlight=False)


def _numbers(name: str, text: str) -> list[float]:
    """Return the three numbers of a body, the first two of which may have units."""
    if (solid := solids().get(text.strip().lower())) is not None:
        body = solid.material
        text = f"{body.shear_modulus}Pa,{body.density}kg/m3,{body.poisson_ratio}"
    parts = text.split(",")
    if len(parts) != len(_KINDS):
        raise SceneError(
            f"--{name} has to be a solid ({', '.join(solids())}) or three numbers as "
            f"30e9,2700,0.25: shear modulus, density and Poisson ratio; got {shown(text)}."
        )
    numbers = []
    for part, (what, dimension) in zip(parts, _KINDS.items(), strict=True):
        try:
            numbers.append(measure(part, dimension, si_size))
        except SceneError as error:
            raise SceneError(f"--{name}: the {what} {error}") from None
    return numbers


def _body(name: str, numbers: list[float]) -> Material:
    """Return the material that three numbers describe, or refuse them by the name of the option."""
    try:
        return Material(*map(float, numbers))
    except SceneError as error:  # it does not know which of the two bodies it is
        raise SceneError(f"--{name}: {str(error).removeprefix('material: ')}") from error
