"""What the evidence page shows: every scene by every method that applies, and the claims judged."""

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
from compare.surveys.workers import Progress, counted
from semianalytic import InterfaceHistory, Material, Scene, Tractions, solve
from semianalytic.reference import PublishedSlip
from semianalytic.reference.known_answers import closed_form, published_answer, published_unit
from semianalytic.scene.errors import SceneError, TensionError
from semianalytic.scene.loading import REMOTE
from semianalytic.scene.named import NAMED_SCENES, find_scene, scene_label

if TYPE_CHECKING:
    from compare.studies.article.cases import Cases
    from compare.studies.article.claims import Claim
    from fem import Simulation

Array = NDArray[np.float64]

FEM = "finite elements"
PUBLISHED = "published algorithm"
RESOLUTION = 100
ARTICLE_RESOLUTION, QUICK_ARTICLE_RESOLUTION = 60, 40
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
        Finite elements; its nodes and times are those of all methods.  With its companions where
        it is judged by them.
    judgements : tuple of Judgement
        One per semi-analytic method, the one the scene calls for first; none under tension.
    published : PublishedSlip or None
        The published algorithm, if the scene has the one load it knows.
    obstacle : str
        Why neither semi-analytic method applies, or nothing.
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
        """The scene itself."""
        return self.simulation.scene

    @property
    def summary(self) -> str:
        """One line saying what the scene shows, or where it comes from."""
        if self.source in NAMED_SCENES:
            return NAMED_SCENES[self.source].summary
        return f"from {self.source}"

    @property
    def coarser(self) -> tuple[Simulation, ...]:
        """The same run on coarser meshes, from which error bars come; none where nothing is
        judged."""
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
        """All rows of all judgements, with the method that predicts."""
        return tuple(
            (method_of(judgement.prediction), row)
            for judgement in self.judgements
            for row in judgement.rows
        )

    @property
    def counts(self) -> Counter[str]:
        """How many rows have each verdict."""
        return Counter(row.verdict for _, row in self.rows)

    @property
    def verdict(self) -> str:
        """That of all judgements together: "differs" if one does, else "agrees" if one does."""
        return overall(judgement.verdict for judgement in self.judgements)

    def published_rate(self) -> Array:
        """Relative slip rate of the published algorithm at nodes and times, (m, n).

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
    """A scene whose slip rate is known in closed form, by every method.

    Attributes
    ----------
    words : str
        What the scene is, and the function of `semianalytic.reference.closed_forms`.
    errors : mapping
        Relative L1 error of the slip rate at T on 0.02 < x/(c_t T) < 1.9, by method.
    edge, solved_edge : float or None
        Velocity of the outer edge over c_t, in closed form and by the self-similar method; None
        where all slips.
    """

    words: str
    errors: Mapping[str, float]
    edge: float | None
    solved_edge: float | None


@dataclass(frozen=True)
class Evidence:
    """All that the page shows.

    Attributes
    ----------
    scenes : tuple of SceneEvidence
    closed_forms : tuple of ClosedForm
    cases : Cases
        The article's scenes, solved and simulated.
    claims : tuple of Claim
    quick : bool
        Whether fewer scenes, figures and a coarser mesh of the article's cases were asked for.
    stamp : mapping
        Versions, machine and date, by name.
    seconds : float
        What it took to compute, figures not included.
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
        """How many rows of all scenes have each verdict."""
        return sum((scene.counts for scene in self.scenes), Counter[str]())

    @property
    def verdict(self) -> str:
        """That of all scenes together, as of the judgements of one."""
        return overall(scene.verdict for scene in self.scenes if scene.judgements)


def excess(row: Row) -> float:
    """Difference of a row over its error bar; infinite where one of the two answers is missing,
    0 of what is unresolved or the same."""
    if row.verdict == UNRESOLVED or row.bar is None or row.difference == 0:
        return 0.0
    if row.difference is None or row.bar == 0:
        return math.inf
    return abs(row.difference) / row.bar


def worst_row(evidence: SceneEvidence) -> tuple[str, Row] | None:
    """The resolved row of a scene that is nearest to its error bar, or farthest beyond."""
    resolved = [pair for pair in evidence.rows if pair[1].verdict != UNRESOLVED]
    return max(resolved, key=lambda pair: excess(pair[1]), default=None)


def differences(evidence: SceneEvidence) -> dict[str, tuple[float, float]]:
    """Mean and largest difference of slip rate at T over V₀ from the first method, by method.

    At the contact nodes on 0.02 < x/(c_t T) < 1.9.
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
    """Simulate a scene, with its companions, and judge every other method that applies by it.

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
        except TensionError as error:  # of a march, where the contact opens
            obstacle = str(error)
    if not predictions:
        return SceneEvidence(source, simulation, (), published_answer(scene), obstacle)
    simulation = with_companions(simulation)
    judgements = tuple(judge(prediction, simulation) for prediction in predictions)
    return SceneEvidence(source, simulation, judgements, published_answer(scene), "")


def closed_forms(resolution: int = RESOLUTION) -> tuple[ClosedForm, ...]:
    """The scenes with closed forms, by the two semi-analytic methods and by finite elements.

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
    if known.edge_speed is not None:  # there slip rate would tell the root of the error of the edge
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

    All named scenes unless given; if quick, four of them, and a coarser mesh for the article.
    Scenes have `resolution` elements per c_t T; `progress` is called after each piece.

    Raises
    ------
    SceneError
        If there is no such scene; before anything is computed.
    ComputationError
        If a method fails.
    """
    from compare.studies.article.cases import run_cases
    from compare.studies.article.study import judge_claims

    chosen = tuple(dict.fromkeys(sources or (QUICK_SCENES if quick else NAMED_SCENES)))
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
    """Versions, machine and date."""
    return {
        "date": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "machine": f"{platform.platform()}, {platform.machine()}, {os.cpu_count()} cores",
        "Python": platform.python_version(),
        **{name: version(name) for name in PACKAGES},
    }
