"""Shell completion: names of scenes, figures, quantities, methods and sheets."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

FIGURES = ("interface",)
METHODS = ("auto", "self-similar", "space-time")
MODES = ("in-plane", "antiplane")
LOADED = ("slot", "remote")
QUANTITIES = (
    *("speed", "pressure", "max-shear", "fringes"),
    *("vx", "vy", "vz", "ux", "uy", "uz", "sxx", "syy", "sxy", "sxz", "syz"),
)
MESH_NAMES = {
    "model": ("auto", "two-blocks"),
    "mesh": ("squares", "triangles"),
}
FORMATS = ("gif", "mp4")
"""Choices of options.  They repeat those of the functions, whose modules import numpy: importing
them would make completion slow."""
Completer = Callable[[str], list[str]]


def one_of(*names: str) -> Completer:
    """Return a completer of fixed names."""
    return lambda incomplete: _starting(names, incomplete)


def scene_names(incomplete: str) -> list[str]:
    """Complete names of scenes, of slipfront and of installed packages, and TOML files."""
    from semianalytic.scene.given.finding import names
    from semianalytic.scene.given.named import NAMED_SPECIMENS

    return _starting([*names(), *NAMED_SPECIMENS, *_toml_files(incomplete)], incomplete)


def figure_names(incomplete: str) -> list[str]:
    """Complete names of figures, of slipfront and of installed packages."""
    from semianalytic.scene.plugins import FIGURES as GROUP
    from semianalytic.scene.plugins import plugin_names

    return _starting([*FIGURES, *plugin_names(GROUP, FIGURES)], incomplete)


def sheets(incomplete: str) -> list[str]:
    """Complete names of benchmark sheets."""
    from compare.benchmarks.sheets import sheet_names

    return _starting(sheet_names(), incomplete)


def _toml_files(incomplete: str) -> list[str]:
    """Return the TOML files of the folder that is being typed."""
    folder = incomplete.rpartition("/")[0]
    try:
        entries = sorted(Path(folder or ("/" if incomplete.startswith("/") else ".")).iterdir())
    except OSError:
        return []
    prefix = incomplete[: incomplete.rfind("/") + 1]
    return [prefix + entry.name for entry in entries if entry.suffix == ".toml"]


def _starting(names: Iterable[str], incomplete: str) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]
