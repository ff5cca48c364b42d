"""Content of the evidence page: every scene by all applicable methods, and the judged claims."""

from __future__ import annotations

import math
import os
import platform
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from compare.comparison.judgement import Judgement, judge
from compare.comparison.measures import in_profile, relative_error
from compare.comparison.prediction import method_of, predict_like
from compare.comparison.rows import UNRESOLVED, Row, overall
from compare.comparison.scales import slip_rate_scale
from compare.tasks.workers import Progress, counted
from semianalytic import InterfaceHistory, Material, Scene, Tractions, solve
from semianalytic.reference import PublishedSlip
from semianalytic.reference.known_answers import closed_form, published_answer, published_unit
from semianalytic.scene.errors import SceneError, TensionError
from semianalytic.scene.given.finding import find_scene, scene_label
from semianalytic.scene.given.named import NAMED_SCENES
from semianalytic.scene.loading import REMOTE

if TYPE_CHECKING:
    from compare.studies.article.cases import Cases
    from compare.studies.article.claims import Claim
    from fem import Simulation

Array = NDArray[np.float64]

FEM = "finite elements"
PUBLISHED = "published algorithm"
RESOLUTION = 100
ARTICLE_RESOLUTION, QUICK_ARTICLE_RESOLUTION = 60, 40
SCENES = tuple(
    name for name, named in NAMED_SCENES.items() if isinstance(named.scene.load, Tractions)
)
"""Scenes of the default page: those whose load comes everywhere at once, which all methods take."""
QUICK_SCENES = ("preloaded", "remote-shock", "auxetic", "ramp")
PACKAGES = ("slipfront", "numpy", "scipy", "scikit-fem", "gmsh", "matplotlib")


@dataclass(frozen=True)
class SceneEvidence:
    """One scene by every method that applies to it.

    Attributes
    ----------
    source : str
        Name of the scene, or path of its file.
    simulation : Simulation
        Finite elements, whose nodes and times all methods use, with coarser companions if it is
        judged.
    judgements : tuple of Judgement
        One judgement per semi-analytic method, beginning with the one that suits the scene; none
        under tension.
    published : PublishedSlip or None
        The published algorithm, if the scene has the one load that it covers.
    obstacle : str
        Reason why no semi-analytic method applies, or an empty string.
    """

    source: str
    simulation: Simulation
    judgements: tuple[Judgement, ...]
    published: PublishedSlip | None
    obstacle: str

    @property
    def label(self) -> str:
        """Short name of the scene."""
        return scene_label(self.source)

    @property
    def scene(self) -> Scene:
        """Scene that the methods answer."""
        return self.simulation.scene

    @property
    def summary(self) -> str:
        """One line on what the scene shows, or on where it comes from."""
        if self.source in NAMED_SCENES:
            return NAMED_SCENES[self.source].summary
        return f"from {self.source}"

    @property
    def coarser(self) -> tuple[Simulation, ...]:
        """Runs on coarser meshes, which give error bars; empty if nothing is judged."""
        return self.judgements[0].case.coarser if self.judgements else ()

    @property
    def histories(self) -> dict[str, InterfaceHistory]:
        """Histories at the contact nodes and times of the simulation, by method."""
        predicted = {method_of(one.prediction): one.case.at_nodes for one in self.judgements}
        return {**predicted, FEM: self.simulation.interface}

    @property
    def methods(self) -> tuple[str, ...]:
        """Names of all methods that were run."""
        return (*self.histories, *([PUBLISHED] if self.published else []))

    @property
    def rows(self) -> tuple[tuple[str, Row], ...]:
        """All rows of all judgements, each with the method that predicts."""
        return tuple(
            (method_of(judgement.prediction), row)
            for judgement in self.judgements
            for row in judgement.rows
        )

    @property
    def counts(self) -> Counter[str]:
        """Number of rows with each verdict."""
        return Counter(row.verdict for _, row in self.rows)

    @property
    def verdict(self) -> str:
        """Verdict on all judgements: "differs" if one of them does, else "agrees" if one does."""
        return overall(judgement.verdict for judgement in self.judgements)

    def published_rate(self) -> Array:
        """Return the relative slip rate of the published algorithm at nodes and times, (m, n).

        Raises
        ------
        SceneError
            If the algorithm does not apply to the scene.
        """
        if self.published is None:
            raise SceneError(f"the published algorithm does not apply to {self.source}.")
        scene, history = self.scene, self.simulation.interface
        slowness = scene.material.shear_speed * history.t[:, None] / history.x
        return np.asarray(published_unit(scene) * self.published.at(slowness))


@dataclass(frozen=True)
class ClosedForm:
    """A scene with a closed form for its slip rate, by every method.

    Attributes
    ----------
    words : str
        Description of the scene, and the function of `semianalytic.reference.closed_forms`.
    errors : mapping
        Relative L1 error of the slip rate at T on 0.02 < x/(c_t T) < 1.9, by method.
    edge, solved_edge : float or None
        Velocity of the outer edge over c_t, in closed form and by the self-similar method; None
        if the whole contact slips.
    """

    words: str
    errors: Mapping[str, float]
    edge: float | None
    solved_edge: float | None


@dataclass(frozen=True)
class Evidence:
    """Content of the evidence page.

    Attributes
    ----------
    scenes : tuple of SceneEvidence
    closed_forms : tuple of ClosedForm
    cases : Cases
        Scenes of the article, solved and simulated.
    claims : tuple of Claim
        Claims of the article with their verdicts.
    quick : bool
        Whether scenes and figures are fewer, and the mesh of the article's cases coarser.
    stamp : mapping
        Versions, machine and date, by name.
    seconds : float
        Time of the computation without figures [s].
    """

    scenes: tuple[SceneEvidence, ...]
    closed_forms: tuple[ClosedForm, ...]
    cases: Cases
    claims: tuple[Claim, ...]
    quick: bool
    stamp: Mapping[str, str]
    seconds: float

    @property
    def counts(self) -> Counter[str]:
        """Number of rows of all scenes with each verdict."""
        return sum((scene.counts for scene in self.scenes), Counter[str]())

    @property
    def verdict(self) -> str:
        """Verdict on all scenes, formed like that on the judgements of one scene."""
        return overall(scene.verdict for scene in self.scenes if scene.judgements)


def excess(row: Row) -> float:
    """Return the difference of a row over its error bar.

    It is infinite if one of the answers is missing, and 0 for rows that are unresolved or equal.
    """
    if row.verdict == UNRESOLVED or row.bar is None or row.difference == 0:
        return 0.0
    if row.difference is None or row.bar == 0:
        return math.inf
    return abs(row.difference) / row.bar


def worst_row(evidence: SceneEvidence) -> tuple[str, Row] | None:
    """Return the resolved row of a scene with the largest difference over its error bar."""
    resolved = [pair for pair in evidence.rows if pair[1].verdict != UNRESOLVED]
    return max(resolved, key=lambda pair: excess(pair[1]), default=None)


def differences(evidence: SceneEvidence) -> dict[str, tuple[float, float]]:
    """Return mean and largest difference of slip rate at T from the first method, over V₀.

    They are taken at the contact nodes on 0.02 < x/(c_t T) < 1.9.
    """
    histories = evidence.histories
    rates = {name: history.slip_rate[-1] for name, history in histories.items()}
    if evidence.published is not None:
        rates[PUBLISHED] = evidence.published_rate()[-1]
    first, *others = rates
    place = histories[first].x / (evidence.scene.material.shear_speed * histories[first].t[-1])
    inside, scale = in_profile(place), slip_rate_scale(evidence.scene)
    gaps = {name: np.abs(rates[name] - rates[first])[inside] / scale for name in others}
    return {name: (float(gap.mean()), float(gap.max())) for name, gap in gaps.items()}


def collect_scene(source: str, resolution: int = RESOLUTION) -> SceneEvidence:
    """Simulate a scene with its companions, and judge all other methods that apply.

    Raises
    ------
    SceneError
        If there is no such scene.
    ComputationError
        If a method fails.
    """
    from fem import simulate, with_companions

    scene = find_scene(source)
    simulation = simulate(scene, resolution=resolution)
    methods = ("self-similar", "space-time") if scene.is_self_similar else ("space-time",)
    predictions, obstacle = [], ""
    for method in methods:
        try:
            predictions.append(predict_like(simulation, method))
        except TensionError as error:  # a march refuses scenes whose contact opens
            obstacle = str(error)
    if not predictions:
        return SceneEvidence(source, simulation, (), published_answer(scene), obstacle)
    simulation = with_companions(simulation)
    judgements = tuple(judge(prediction, simulation) for prediction in predictions)
    return SceneEvidence(source, simulation, judgements, published_answer(scene), "")


def closed_forms(resolution: int = RESOLUTION) -> tuple[ClosedForm, ...]:
    """Compare closed forms with the two semi-analytic methods and the finite elements.

    Raises
    ------
    ComputationError
        If a method fails.
    """
    solid = Material(shear_modulus=1.0, density=1.0, poisson_ratio=1 / 3)
    nothing, pressure = Tractions(0.0, 0.0), Tractions(1.0, 0.0)
    shear, both = Tractions(0.0, 1.0), Tractions(1.0, 1.0)
    scenes = {
        "constant pressure, sudden shear, friction 1: one slow zone, slip_rate_under_shear_step": (
            Scene(solid, 1.0, base=pressure, load=shear)
        ),
        "sudden remote load, friction 0.5: slip everywhere, slip_rate_under_remote_shock": (
            Scene(solid, 0.5, base=nothing, load=both, load_on=REMOTE)
        ),
        "sudden shear without friction: slip behind the P wave, slip_rate_without_friction": (
            Scene(solid, 0.0, base=pressure, load=shear)
        ),
    }
    return tuple(_closed_form(words, scene, resolution) for words, scene in scenes.items())


def _closed_form(words: str, scene: Scene, resolution: int) -> ClosedForm:
    from fem import simulate

    known, speed = closed_form(scene), scene.material.shear_speed
    simulation = simulate(scene, resolution=resolution)
    history, end = simulation.interface, simulation.end_time
    shown = in_profile(history.x / (speed * end))
    if known.edge_speed is not None:  # at the edge, the slip rate would tell the root of its error
        shown &= ~np.isclose(history.x / end, known.edge_speed, rtol=1e-9)
    velocity, solution = history.x[shown] / end, solve(scene)
    rates = {
        "self-similar": solution.slip_rate(velocity, 1.0),
        "space-time": predict_like(simulation, "space-time").slip_rate(velocity * end, end),
        FEM: history.slip_rate[-1, shown],
    }
    exact = known.slip_rate(velocity)
    errors = {name: relative_error(rate, exact, velocity, 1) for name, rate in rates.items()}
    if known.edge_speed is None:
        return ClosedForm(words, errors, None, None)
    return ClosedForm(words, errors, known.edge_speed / speed, solution.zones[-1].outer / speed)


def collect(
    sources: Sequence[str] = (),
    *,
    quick: bool = False,
    resolution: int = RESOLUTION,
    progress: Progress | None = None,
) -> Evidence:
    """Run all methods on all scenes, and judge the claims of the article.

    All named scenes are run unless `sources` are given.  If `quick`, only four of them are run, and
    the article's cases have a coarser mesh.  Scenes have `resolution` elements per c_t T;
    `progress` is called after each piece of work.

    Raises
    ------
    SceneError
        If there is no such scene; raised before anything is computed.
    ComputationError
        If a method fails.
    """
    from compare.studies.article.cases import run_cases
    from compare.studies.article.study import judge_claims

    chosen = tuple(dict.fromkeys(sources or (QUICK_SCENES if quick else SCENES)))
    for source in chosen:
        find_scene(source)
    started = time.perf_counter()
    pieces: list[Callable[[], Any]] = [partial(collect_scene, one, resolution) for one in chosen]
    pieces.append(partial(closed_forms, resolution))
    pieces.append(partial(run_cases, QUICK_ARTICLE_RESOLUTION if quick else ARTICLE_RESOLUTION))
    *scenes, forms, cases = counted((piece() for piece in pieces), len(pieces), progress)
    claims, seconds = judge_claims(cases), time.perf_counter() - started
    return Evidence(tuple(scenes), forms, cases, claims, quick, _stamp(), seconds)


def _stamp() -> dict[str, str]:
    """Return versions, machine and date."""
    return {
        "date": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "machine": f"{platform.platform()}, {platform.machine()}, {os.cpu_count()} cores",
        "Python": platform.python_version(),
        **{name: version(name) for name in PACKAGES},
    }
