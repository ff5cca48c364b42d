"""Inputs to start from for two public codes, UGUCA and SEM2DPACK.

They are our own text: parameters and meshes of the sheets, as those codes read them, for `CELLS`
cells over c_t T, in units mu = rho = c_t = 1.  UGUCA is a library, so that a program comes with
them; SEM2DPACK takes lengths and times `SCALE` times as large, and has no viscous film.  What is
damped there is the least that keeps slip rates quiet: one layer of elements where the upper body is
alone, two of each where both are there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from compare.benchmarks.sheet import Sheet
from compare.output.files import filled_template
from semianalytic import Material, Pulse, Scene, ViscousFriction, find

CELLS = 40
LENGTH, SLOT = 5.2, 2.2
"""Period of UGUCA's interface, and the part of it that is slot, over c_t T: no wave of the far edge
reaches a station until T, unless it is faster than 2 c_t.  Different bodies have faster ones, and
lengths larger in proportion."""
FASTEST = 2.0
SCALE = 100.0
LEFT, RIGHT, DEPTH = 2.0, 1.5, 1.0
"""Extents of SEM2DPACK's blocks, over c_t T; no reflection reaches a station until T.  Different
bodies have them larger in proportion to their fastest wave."""
NGLL, DAMPED_LAYERS = 5, 2
SOLIDS = {"up": (1, 2), "low": (3, 4)}
"""Tags of the solids of both bodies, plain and damped."""
CONTACT, SLOT_FACES = {"low": 5, "up": 6}, {"low": 7, "up": 8}
"""Tags of the boundaries of the SEM2DPACK mesh."""


def starter_inputs(sheet: Sheet) -> Mapping[str, str]:
    """Texts of the inputs for a sheet by file name, code/name.

    There are none where there is no slot, or where the load comes to one place after the other, and
    for interfaces.
    """
    if sheet.is_interface or sheet.is_line or sheet.scene.front_slowness:
        return {}
    inputs = {
        f"uguca/{sheet.name}.in": uguca_parameters(sheet),
        "uguca/uguca_sheet.cc": filled_template("compare.benchmarks", "uguca_sheet.cc"),
    }
    for name, text in sem2dpack_files(sheet).items():
        inputs[f"sem2dpack/{name}"] = text
    return inputs


def _shear_until(scene: Scene) -> float:
    """When the shear goes off again; after T if it stays."""
    history = scene.shear_history
    return history.duration if isinstance(history, Pulse) else 2.0


def _is_pressed(scene: Scene) -> bool:
    """Whether the load changes the pressure, so that both bodies have to be there.

    Those of the sheets that differ are pressed.
    """
    return scene.superposition.taken_off.pressure != 0


def _lower_of(sheet: Sheet) -> Material:
    """Return the solid of the lower body of a sheet."""
    return find(sheet.name).lower if sheet.is_pair else sheet.scene.material


def _wider(lower: Material) -> float:
    """Return the factor, 1 or more, by which waves of the lower body lengthen a mesh."""
    return max(1.0, lower.longitudinal_speed / FASTEST)


def uguca_parameters(sheet: Sheet) -> str:
    """The parameters that ``uguca_sheet.cc`` reads."""
    scene, law = sheet.scene, sheet.scene.friction_law
    axis, pressed, (held, load) = 2 * scene.antiplane, _is_pressed(scene), scene.superposition
    fields = [f"cohesion_{axis}", "cohesion_1", f"top_disp_{axis}", f"top_velo_{axis}"]
    if pressed:
        fields += ["bot_disp_0", "bot_velo_0"]
    lower = _lower_of(sheet)
    wider = _wider(lower)
    lines = (
        ("string", "name", sheet.name),
        ("string", "kernels", "kernels/"),
        ("int", "axis", axis),
        ("int", "pressed", int(pressed)),
        ("int", "cells", CELLS),
        ("int", "steps_per_cell", 4),
        ("double", "length", round(wider * LENGTH * CELLS) / CELLS),
        ("int", "slot_nodes", round(wider * SLOT * CELLS)),
        ("double", "poisson_ratio", repr(scene.material.poisson_ratio)),
        ("double", "lower_shear_modulus", lower.shear_modulus),
        ("double", "lower_density", lower.density),
        ("double", "lower_poisson_ratio", repr(lower.poisson_ratio)),
        ("double", "friction", scene.friction),
        ("double", "viscosity", law.viscosity if isinstance(law, ViscousFriction) else 0.0),
        ("double", "contact_pressure", held.pressure),
        ("double", "contact_shear", held.shear),
        ("double", "slot_pressure", load.pressure),
        ("double", "slot_shear", load.shear),
        ("double", "shear_until", _shear_until(scene)),
        ("string", "dump_fields", ",".join(fields)),
    )
    heading = f"# slipfront benchmark {sheet.name}, mu = rho = c_t = T = 1\n"
    return heading + "".join(f"{kind} {name} = {value}\n" for kind, name, value in lines)


def sem2dpack_files(sheet: Sheet) -> dict[str, str]:
    """Par.inp, the tables of loads it names, and the mesh where both bodies are needed.

    Nothing where there is a viscous film.
    """
    scene, lower = sheet.scene, _lower_of(sheet)
    if isinstance(scene.friction_law, ViscousFriction):
        return {}
    elements = CELLS // (NGLL - 1)
    fastest = max(scene.material.longitudinal_speed, lower.longitudinal_speed)
    pressed, steps = _is_pressed(scene), _steps(fastest, elements)
    load = scene.superposition.taken_off
    loads = {"up.x": load.shear}
    if pressed:
        loads |= {"up.y": -load.pressure, "low.x": -load.shear, "low.y": load.pressure}
    files = {
        name: _load_table(value, _shear_until(scene) if name.endswith("x") else 2.0, SCALE / steps)
        for name, value in loads.items()
    }
    if pressed:
        files["two.mesh2d"] = "".join(_two_blocks(elements, _wider(lower), lower == scene.material))
    mesh = _pressed_mesh() if pressed else _sheared_mesh(elements)
    bounds = _pressed_bounds(scene) if pressed else _sheared_bounds(scene)
    kind = f"ndof={1 if scene.antiplane else 2}, title='{sheet.name}', verbose='1111'"
    blocks = [
        f"&GENERAL iexec=1, ngll={NGLL}, fmax=0.1d0, {kind}, ItInfo=1000 /",
        *mesh,
        *_materials(scene, lower),
        *bounds,
        f"&TIME NbSteps={steps}, Dt={SCALE / steps:.12g}, kind='leapfrog' /",
    ]
    return {"Par.inp": "\n".join(blocks) + "\n", **files}


def _load_table(value: float, until: float, step: float) -> str:
    """A load over time, gone after a time; by points a fortieth of a time step apart where it goes.

    The code puts a cubic spline through them, which would swing far beyond few points.
    """
    times = np.array([0, 2 * SCALE])
    if until >= 1:  # it stays, beyond the end of the table too
        until = math.inf
    else:
        near = until * SCALE + step * (np.arange(-120, 120) + 0.5) / 40
        before, after = np.linspace(0, near[0], 400), np.linspace(near[-1], 2 * SCALE, 800)
        times = np.concatenate([before[:-1], near, after[1:]])
    return "".join(f"{t:.12g} {value if t < until * SCALE else 0:g}\n" for t in times)


def _sheared_mesh(elements: int) -> list[str]:
    """The upper body alone, a layer of one element on the contact damped."""
    return [
        "&MESH_DEF method='CARTESIAN' /",
        f"&MESH_CART xlim={-LEFT * SCALE:g},{RIGHT * SCALE:g}, zlim=0,{DEPTH * SCALE:g}, "
        f"nelem={round((LEFT + RIGHT) * elements)},{round(DEPTH * elements)}, "
        "fztag=2, fznz=1, split=T, splitD=0d0 /",
    ]


def _pressed_mesh() -> list[str]:
    return ["&MESH_DEF method='MESH2D' /", "&MESH_MESH2D file='two.mesh2d' /"]


def _materials(scene: Scene, lower: Material) -> list[str]:
    """The solids, and the same with Kelvin-Voigt damping beside the contact; tags of both bodies
    where they differ, else of the upper one alone."""
    lines = []
    bodies = {"up": scene.material} | ({} if lower == scene.material else {"low": lower})
    for side, body in bodies.items():
        density, shear = f"{body.density:.15g}d0", f"{body.shear_speed:.15g}"
        shear += "d0" if shear.isdigit() else ""
        speed = f"{body.longitudinal_speed:.15g}"
        elastic = [f"&MAT_ELASTIC rho={density}, cp={speed}, cs={shear} /"]
        if body.poisson_ratio < 0:  # refused as a number, not as a distribution
            elastic = [
                f"&MAT_ELASTIC rho={density}, cpH='ORDER0', cs={shear} /",
                f"&DIST_ORDER0 xn=1, zn=1 /\n{speed}",
            ]
        plain, damped = SOLIDS[side]
        lines += [
            f"&MATERIAL tag={plain}, kind='ELAST' /",
            *elastic,
            f"&MATERIAL tag={damped}, kind='ELAST','KV' /",
            *elastic,
            f"&MAT_KV eta={0.3 if _is_pressed(scene) else 0.2} /",
        ]
    return lines


def _friction(scene: Scene, shear: float) -> list[str]:
    """The contact under what is in place: friction that slip does not weaken."""
    return [
        f"&BC_DYNFLT friction='SWF', Tn={-scene.superposition.in_place.pressure:g}, Tt={shear:g}, "
        f"otd={SCALE / 200:g} /",
        f"&BC_DYNFLT_SWF Dc=1d0, MuS={scene.friction:.10g}, MuD={scene.friction:.10g} /",
    ]


def _sheared_bounds(scene: Scene) -> list[str]:
    held = scene.superposition.in_place.shear
    return [
        "&BC_DEF tag=5, kind='DIRNEU' /",
        "&BC_DIRNEU h='N', v='N', hstf='TAB' /",
        "&STF_TAB file='up.x' /",
        "&BC_DEF tag=1, kind='DYNFLT' /",
        *_friction(scene, -held if scene.antiplane else held),
    ]


def _pressed_bounds(scene: Scene) -> list[str]:
    lines = []
    for side in ("up", "low"):
        lines += [
            f"&BC_DEF tag={SLOT_FACES[side]}, kind='DIRNEU' /",
            "&BC_DIRNEU h='N', v='N', hstf='TAB', vstf='TAB' /",
            f"&STF_TAB file='{side}.x' /",
            f"&STF_TAB file='{side}.y' /",
        ]
    tags = f"{CONTACT['low']},{CONTACT['up']}"
    held = scene.superposition.in_place.shear
    return [*lines, f"&BC_DEF tags={tags}, kind='DYNFLT' /", *_friction(scene, held)]


def _steps(fastest: float, elements: int) -> int:
    """Time steps, 200 times a whole number, for the speed of the fastest wave."""
    longest = 0.069 * SCALE / elements / fastest
    return 200 * math.ceil(SCALE / longest / 200)


def _two_blocks(elements: int, wider: float, alike: bool) -> Iterator[str]:
    """Both bodies with separate nodes on y = 0, in the format MESH2D; tags are those of `SOLIDS`,
    and of the upper body alone where both are alike."""
    left, right, down = (math.ceil(wider * one * elements) for one in (LEFT, RIGHT, DEPTH))
    across = left + right
    row = across + 1
    nodes = row * (down + 1)
    yield f"NEL NPEL NNOD NBC\n{2 * across * down} 4 {2 * nodes} 4\nNID X Y\n"
    size = SCALE / elements
    for block in range(2):
        for node in range(nodes):
            x = size * (node % row - left)
            y = size * (node // row - (0 if block else down))
            yield f"{block * nodes + node + 1} {x:.10g} {y:.10g}\n"
    yield "EID NODES TAG\n"
    for block in range(2):
        for element in range(across * down):
            level = element // across
            corner = block * nodes + level * row + element % across + 1
            plain, damped = SOLIDS["up" if block or alike else "low"]
            tag = damped if (level if block else down - 1 - level) < DAMPED_LAYERS else plain
            number = block * across * down + element + 1
            yield f"{number} {corner} {corner + 1} {corner + row + 1} {corner + row} {tag}\n"
    first = {"low": (down - 1) * across + 1, "up": across * down + 1}
    edge = {"low": 3, "up": 1}
    for tags, places in ((CONTACT, range(left, across)), (SLOT_FACES, range(left))):
        for side, tag in tags.items():
            yield f"BCTAG NBEL\n{tag} {len(places)}\nBID EID EDGE\n"
            for number, place in enumerate(places, start=1):
                yield f"{number} {first[side] + place} {edge[side]}\n"
