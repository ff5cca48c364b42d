"""Figures exist, say what they show, and hold finite data."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import solved, under
from compare_cases import SELF_SIMILAR, sampled_run
from matplotlib.figure import Figure

from compare.comparison.fields.errors import field_errors
from compare.comparison.judgement import side_by_side
from compare.comparison.prediction import predict_like
from compare.comparison.quantities.local_rows import worst_places
from compare.comparison.scales import scene_fronts
from compare.figures.histories import comparison_figures, curve
from compare.figures.interface import (
    fronts_figure,
    interface_figure,
)
from compare.figures.saving import save_figure
from compare.figures.snapshots import snapshot_figure
from compare.figures.style import scene_words
from fem import simulate
from semianalytic import RateWeakening, Tractions
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.given.named import NAMED_SCENES


@pytest.fixture(scope="module", params=SELF_SIMILAR)
def drawn(request):
    """A prediction, and figures that show a run without error beside it."""
    solution = solved(NAMED_SCENES[request.param].scene)
    history = sampled_run(solution, resolution=50, companions=0).interface
    figures = {
        "interface": interface_figure(solution, history),
        "fronts": fronts_figure(solution, history),
    }
    return solution, history, figures


def assert_finite(panel):
    for line in panel.get_lines():
        assert np.isfinite(line.get_ydata()).all()
    assert np.isfinite(panel.dataLim.get_points()).all()


@pytest.mark.thinned(6)
def test_interface_figure_shows_both_answers_and_their_difference(drawn):
    solution, history, figures = drawn
    upper, middle, lower = figures["interface"].axes
    labels = [panel.get_ylabel() for panel in (upper, middle, lower)]
    assert labels == ["slip rate", "traction", "difference"]
    assert lower.get_xlabel() == "x"
    waves = set(", ".join(text.get_text() for text in upper.texts).split(", "))
    assert waves == ({"$c_t$"} if solution.scene.antiplane else {"$c_R$", "$c_t$", "$c_l$"})
    for panel in (upper, middle, lower):
        assert_finite(panel)
    samples = [line for line in upper.get_lines() if line.get_marker() == "."]
    assert [len(line.get_xdata()) > 20 for line in samples] == [True]
    assert any(line.get_marker() == "." for line in middle.get_lines())
    # A run that samples the prediction differs from it by nothing but rounding.
    difference = next(line for line in lower.get_lines() if len(line.get_xdata()) > 20)
    assert np.abs(difference.get_ydata()).max() < 1e-12 * np.abs(history.slip_rate).max() + 1e-12


@pytest.mark.thinned(6)
def test_fronts_figure_maps_position_and_time(drawn):
    solution, _, figures = drawn
    panel, colour_bar = figures["fronts"].axes
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("x", "t")
    assert colour_bar.get_ylabel().startswith("slip rate")
    kinds = solution.zones, solution.openings
    edges = [{e for part in of for e in (part.inner, part.outer)} - {0, np.inf} for of in kinds]
    assert len(panel.get_lines()) == len(scene_fronts(solution.scene)) + sum(map(len, edges))
    (mesh,) = panel.collections
    assert np.isfinite(mesh.get_array()).all()


@pytest.mark.slow
def test_reverse_slip_is_named_in_the_legend_and_mapped_with_two_colours():
    scene = NAMED_SCENES["preloaded"].scene
    mirrored = solved(replace(scene, load=Tractions(0.0, -1.0)))
    history = sampled_run(mirrored, resolution=50, companions=0).interface
    upper, *_ = interface_figure(mirrored, history).axes
    assert "reverse slip" in [text.get_text() for text in upper.get_legend().get_texts()]
    (mesh,) = fronts_figure(mirrored, history).axes[0].collections
    assert mesh.norm.vmin == -mesh.norm.vmax


def test_places_beyond_their_bars_are_marked_in_the_map_of_differences():
    solution = solved(NAMED_SCENES["preloaded"].scene)
    right = sampled_run(solution, resolution=50)
    name, at, _ = next(worst_places(side_by_side(solution, right)))
    rate = right.interface.slip_rate.copy()
    rate[at] += rate.max()
    wrong = replace(right, interface=replace(right.interface, slip_rate=rate))
    for run, marked in ((right, []), (wrong, ["slip rate"])):
        case = side_by_side(solution, run)
        panel = comparison_figures(case)["sense"](case).axes[2]
        assert [text.get_text() for text in panel.texts if "rate" in text.get_text()] == marked
    (mark,) = (line for line in panel.lines if line.get_marker() == "o")
    place = case.seen.x[at[1]] / case.length, case.seen.t[at[0]] / case.end_time
    np.testing.assert_allclose(mark.get_xydata(), [place])
    assert name == "slip_rate"


@pytest.mark.slow
def test_what_is_open_is_shaded_named_and_drawn():
    solution = solved(NAMED_SCENES["lift-off-shear"].scene)
    run = sampled_run(solution, resolution=50)
    upper, *_ = interface_figure(solution, run.interface).axes
    assert [text.get_text() for text in upper.get_legend().get_texts()][-1] == "open"
    case = side_by_side(solution, run)
    figures = comparison_figures(case)
    gap, pressure = figures["gap"](case).axes
    assert (gap.get_ylabel()[:3], pressure.get_ylabel()[:8]) == ("gap", "pressure")
    seen, predicted = gap.get_lines()[-2:]  # at the end
    assert predicted.get_ydata().max() > 0.1
    np.testing.assert_allclose(
        np.interp(seen.get_xdata(), *predicted.get_data()), seen.get_ydata(), atol=1e-3
    )
    sense, *_ = figures["sense"](case).axes
    assert sense.collections[0].get_array().max() == 2
    closed = solved(NAMED_SCENES["preloaded"].scene)
    assert "gap" not in comparison_figures(side_by_side(closed, sampled_run(closed, 50)))


@pytest.mark.parametrize(
    ("name", "refusal", "words"),
    [
        ("line.docx", SceneError, r"end the name in \.png"),
        ("line", SceneError, r"end the name in \.png"),
        ("taken/line.png", DataFileError, "Cannot write"),
    ],
)
def test_formats_and_places_that_are_none_are_refused(tmp_path, name, refusal, words):
    (tmp_path / "taken").write_text("")
    with pytest.raises(refusal, match=words):
        save_figure(Figure(), tmp_path / name)
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]


def test_units_are_named_by_the_traction_they_are():
    scene = NAMED_SCENES["preloaded"].scene
    assert "τ₀ = shear of the load = 1" in scene_words(scene)
    resting = replace(scene, load=type(scene.load)(0.0, 0.0))
    assert "τ₀ = pressure of the base = 1" in scene_words(resting)
    assert "antiplane" in scene_words(replace(scene, mode="antiplane"))
    words = scene_words(under(scene, RateWeakening(1.0, 0.6, 1.0)))
    assert f"rate-weakening (dynamic {0.6 * scene.coefficient:.3g}, rate 1)" in words


@pytest.mark.thinned(2)
@pytest.mark.parametrize("method", ["self-similar", "space-time"])
def test_a_prediction_is_drawn_finer_than_the_nodes(method):
    """And agrees there with what is compared."""
    run = sampled_run(solved(NAMED_SCENES["preloaded"].scene), resolution=25)
    case = side_by_side(predict_like(run, method), run)
    nodes = case.at_nodes
    x, slip_rate = curve(case.prediction, float(nodes.x[-1]), float(nodes.t[-1]))
    assert len(x) > 3.5 * len(nodes.x)
    smooth = nodes.x < 0.5
    drawn = np.interp(nodes.x[smooth], x, slip_rate)
    assert drawn == pytest.approx(nodes.slip_rate[-1, smooth], rel=1e-3)


def test_a_prediction_that_is_no_solution_has_the_figures_that_need_none(solution):
    run = sampled_run(solution, resolution=25)
    exact, marched = (
        set(comparison_figures(side_by_side(predict_like(run, method), run)))
        for method in ("self-similar", "space-time")
    )
    assert marched == {"sense", "history"}
    assert exact - marched == {"interface", "fronts"}


@pytest.mark.slow
def test_snapshot_figure_shows_both_bodies_exact_simulated_and_the_difference(tmp_path):
    scene = NAMED_SCENES["lift-off-shear"].scene  # the two bodies move differently
    solution, run = solved(scene), simulate(scene, resolution=20, snapshots=tmp_path, frames=1)
    errors = field_errors(solution, run, tmp_path)
    figure = snapshot_figure(errors, run)
    exact, seen, difference = (panel.images[0] for panel in figure.axes[:3])
    assert exact.get_clim() == seen.get_clim()
    np.testing.assert_allclose(
        difference.get_array(), seen.get_array() - exact.get_array(), atol=1e-12
    )
    left, right, bottom, top = exact.get_extent()
    assert -left == right == -bottom == top > 2  # beyond c_l T
    speeds = exact.get_array()
    middle = (np.arange(len(speeds)) + 0.5) / len(speeds) * (top - bottom) + bottom
    for row, column in ((125, 125), (375, 125), (260, 330), (240, 330)):
        x, y = middle[column], middle[row]
        speed = np.linalg.norm(solution.velocity(x, y, 1.0)) / 2  # V_0 = 2
        assert speeds[row, column] == pytest.approx(speed, abs=0.05)
    assert figure.get_suptitle() == scene_words(scene)
