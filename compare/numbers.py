"""Every number that README and docs quote, computed again and compared with the text.

``python -m compare.numbers`` reads docs/numbers.toml, where each entry names the pages, the text as
it stands there with its numbers in «guillemets», the function of `compare.number_functions` that
computes them, and how closely they have to agree.  It fails if a text is not in its page or a
number is off.
"""

from __future__ import annotations

import argparse
import math
import re
import tomllib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from operator import attrgetter
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from compare import number_functions
from compare.comparison.report import default_report
from compare.figures.histories import comparison_figures
from compare.figures.saving import figure_png
from semianalytic.results.files import write_bytes
from semianalytic.scene.errors import SlipfrontError

ROOT = Path(__file__).resolve().parents[1]
LIST = ROOT / "docs" / "numbers.toml"

# --- the list ---------------------------------------------------------------------------------

_SUPERSCRIPT = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻"
_DIGITS = str.maketrans(_SUPERSCRIPT + "−", "0123456789--")
_QUOTED = re.compile("«([^»]*)»")
_NUMBER = re.compile(
    rf"(?P<sign>[+−-]?)(?P<mantissa>\d[\d,]*(?:\.\d+)?)?(?P<power>·?10[{_SUPERSCRIPT}]+)?"
    r"(?:e(?P<exponent>[-+]?\d+))?(?P<percent> ?%)?"
)
AGREEMENTS = ("relative", "absolute", "units", "factor", "at_most", "at_least")


@dataclass(frozen=True)
class Quoted:
    """A number as it is written: its value, and one unit of its last digit."""

    written: str

    def _parts(self) -> re.Match[str]:
        match = _NUMBER.fullmatch(self.written)
        if match is None or not (match["mantissa"] or match["power"]):
            raise ValueError(f"«{self.written}» is not a number this script can read.")
        return match

    @property
    def value(self) -> float:
        """The number; percents as fractions."""
        match = self._parts()
        mantissa = float((match["mantissa"] or "1").replace(",", ""))
        return (-1 if match["sign"] in ("−", "-") else 1) * mantissa * self._scale

    @property
    def unit(self) -> float:
        """One unit of the last digit."""
        return 10.0**-self._decimals * self._scale

    @property
    def _decimals(self) -> int:
        _, _, fraction = (self._parts()["mantissa"] or "1").partition(".")
        return len(fraction)

    @property
    def _scale(self) -> float:
        match = self._parts()
        exponent = int(match["exponent"] or 0)
        if match["power"]:
            exponent += int(match["power"].split("10", 1)[1].translate(_DIGITS))
        return float(f"1e{exponent - (2 if match['percent'] else 0)}")

    def rewritten(self, value: float) -> str:
        """Another value in the same style."""
        if not math.isfinite(value):
            return str(value)
        match, decimals = self._parts(), self._decimals
        percent = match["percent"] or ""
        sign = ("−" if match["sign"] != "-" else "-") if value < 0 else match["sign"]
        sign = "+" if sign == "+" and value >= 0 else sign if value < 0 else ""
        size = abs(value) * (100 if percent else 1)
        if not (match["power"] or match["exponent"]):
            thousands = "," if "," in match["mantissa"] else ""
            return f"{sign}{size:{thousands}.{decimals}f}{percent}"
        mantissa, _, exponent = f"{size:.{decimals}e}".partition("e")
        if match["exponent"]:
            return f"{sign}{mantissa}e{int(exponent)}{percent}"
        raised = "".join(_SUPERSCRIPT["0123456789-".index(one)] for one in str(int(exponent)))
        lead = f"{mantissa}·" if match["mantissa"] else ""
        return f"{sign}{lead}10{raised}{percent}"


@dataclass(frozen=True)
class Entry:
    """One text of one or more pages, and how its numbers are computed.

    Attributes
    ----------
    id : str
    pages : tuple of str
        Paths from the root of the repository.
    text : str
        As in the page, numbers in guillemets; white space does not count.
    function : str
        Of `compare.number_functions`, dotted if it is one of a module imported there.
    arguments : tuple
        What it is called with.
    each : tuple
        It is called once with each of these (one or a list of arguments) after the others; once
        with the others alone if there are none.
    times : float
        What the values are multiplied by, 100 for percents.
    agreement, tolerance : str, float
        "relative", "absolute", "units" of the last digit, "factor" (to either side), or "at_most"
        and "at_least" (bounds: tolerance is a factor of slack, 1 for none).
    slow : bool
        Takes more than seconds.
    """

    id: str
    pages: tuple[str, ...]
    text: str
    function: str
    agreement: str
    tolerance: float
    arguments: tuple[Any, ...] = ()
    each: tuple[Any, ...] = ()
    times: float = 1.0
    slow: bool = False

    @property
    def quoted(self) -> tuple[Quoted, ...]:
        """The numbers, in order."""
        return tuple(Quoted(written) for written in _QUOTED.findall(self.text))

    @property
    def plain(self) -> str:
        """The text as it should stand in the page."""
        return _QUOTED.sub(r"\1", self.text)

    def missing_pages(self) -> list[str]:
        """Pages that do not hold the text."""
        wanted = _squeezed(self.plain)
        return [page for page in self.pages if wanted not in _page(page)]

    def computed(self) -> list[float]:
        """What the function says now, one value per quoted number.

        Raises
        ------
        ValueError
            If there are not as many.
        """
        function: Callable[..., Any] = attrgetter(self.function)(number_functions)
        calls = [one if isinstance(one, list) else [one] for one in self.each] or [[]]
        found = [np.ravel(function(*self.arguments, *call)) for call in calls]
        values = [self.times * float(value) for value in np.concatenate(found)]
        if len(values) != len(self.quoted):
            raise ValueError(f"{self.id}: {len(self.quoted)} numbers quoted, {len(values)} found.")
        return values

    def agrees(self, quoted: Quoted, value: float) -> bool:
        """Whether a computed value is near enough to the quoted one."""
        wanted, tolerance = quoted.value, self.tolerance
        if not math.isfinite(value):
            return False
        if self.agreement == "at_most":
            return value <= wanted * tolerance
        if self.agreement == "at_least":
            return value >= wanted / tolerance
        if self.agreement == "factor":
            return bool(value * wanted > 0 and max(value / wanted, wanted / value) <= tolerance)
        scale = {"relative": abs(wanted), "absolute": 1.0, "units": quoted.unit}[self.agreement]
        return bool(abs(value - wanted) <= tolerance * scale * (1 + 1e-9))

    def rewritten(self, values: Iterable[float]) -> str:
        """The text with other numbers, in the same style."""
        old = iter(zip(self.quoted, values, strict=True))

        def new(_: re.Match[str]) -> str:
            quoted, value = next(old)
            return quoted.written if self.agrees(quoted, value) else quoted.rewritten(value)

        return _QUOTED.sub(new, self.text)


def read_list(path: Path = LIST) -> list[Entry]:
    """All entries of docs/numbers.toml.

    Raises
    ------
    ValueError
        If one is not complete, or its function does not exist.
    """
    entries = []
    for raw in tomllib.loads(path.read_text(encoding="utf-8"))["number"]:
        given: dict[str, Any] = {
            key: tuple(v) if isinstance(v, list) else v for key, v in raw.items()
        }
        kinds = [kind for kind in AGREEMENTS if kind in given]
        if len(kinds) != 1:
            raise ValueError(f"{given.get('id')}: give one of {', '.join(AGREEMENTS)}.")
        tolerance = float(given.pop(kinds[0]))
        try:
            entry = Entry(**given, agreement=kinds[0], tolerance=tolerance)
            attrgetter(entry.function)(number_functions)
        except (TypeError, AttributeError) as error:
            raise ValueError(f"{given.get('id')}: {error}.") from error
        if not entry.quoted:
            raise ValueError(f"{entry.id}: no number in «guillemets».")
        entries.append(entry)
    return entries


def _squeezed(text: str) -> str:
    return " ".join(text.split())


@cache
def _page(name: str) -> str:
    path = ROOT / name
    return _squeezed(path.read_text(encoding="utf-8")) if path.is_file() else ""


# --- comparing ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Finding:
    """What became of an entry: what is wrong, and what to change; both empty if nothing."""

    entry: Entry
    problem: str = ""
    change: str = ""
    seconds: float = 0.0


def check(entry: Entry) -> Finding:
    """Compare one entry with its pages and with what is computed now."""
    started = perf_counter()
    missing = entry.missing_pages()
    problems = [f"{', '.join(missing)} does not say «{entry.plain}»"] if missing else []
    try:
        values = entry.computed()
    except (SlipfrontError, ValueError, KeyError, StopIteration) as error:
        return Finding(entry, f"cannot be computed: {error}", "", perf_counter() - started)
    off = [
        f"{quoted.written} is {value:.6g}"
        for quoted, value in zip(entry.quoted, values, strict=True)
        if not entry.agrees(quoted, value)
    ]
    if off:
        problems.append(", ".join(off))
    change = entry.rewritten(values) if off else ""
    return Finding(entry, "; ".join(problems), change, perf_counter() - started)


FIGURES = {
    "remote-shock": "slip_rate.png",
    "stuck": "tractions.png",
    "auxetic": "sense.png",
    "ramp": "sense.png",
    "unload": "sense.png",
    "pulse": "sense.png",
    "harmonic": "sense.png",
    "pressure-drop": "sense.png",
}
"""Which figure of `slipfront compare SCENE` docs/scenes.md shows."""


def write_figures() -> None:
    """Write the figures of docs/scenes.md as scene_NAME.png, in few colours to keep them small."""
    for scene, name in FIGURES.items():
        path = ROOT / "docs" / "figures" / f"scene_{scene}.png"
        report = default_report(scene)
        write_bytes(path, figure_png(comparison_figures(report)[name](report), 100, 64))
        print(f"{path} {path.stat().st_size / 1000:.0f} kB")


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare the numbers of README and docs with the code; 1 if one is off or not there."""
    parser = argparse.ArgumentParser(prog="python -m compare.numbers", description=__doc__)
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--check", action="store_true", help="compare (the default)")
    what.add_argument("--write", action="store_true", help="compare, and print what to change")
    what.add_argument("--figures", action="store_true", help="draw those of docs/scenes.md again")
    parser.add_argument("--cheap", action="store_true", help="leave out what takes long")
    parser.add_argument("--verbose", action="store_true", help="print every entry and its time")
    parser.add_argument("ids", nargs="*", help="entries whose id begins so; all unless given")
    options = parser.parse_args(arguments)
    if options.figures:
        write_figures()
        return 0
    entries = [
        entry
        for entry in read_list()
        if (not options.ids or entry.id.startswith(tuple(options.ids)))
        and not (options.cheap and entry.slow)
    ]
    wrong = 0
    for entry in entries:
        finding = check(entry)
        if finding.problem:
            wrong += 1
            print(f"{entry.id}: {finding.problem}", flush=True)
            if options.write and finding.change:
                print(f"  {', '.join(entry.pages)}: write\n  {finding.change}", flush=True)
        elif options.verbose:
            print(f"{entry.id}: fine, {finding.seconds:.1f} s", flush=True)
    count = sum(len(entry.quoted) for entry in entries)
    print(f"{count} numbers in {len(entries)} texts, {wrong} texts to correct.")
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
