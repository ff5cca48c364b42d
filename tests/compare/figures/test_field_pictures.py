"""Pictures of fields: fronts are where the fields change, names and colours say what is shown."""

import itertools

import numpy as np
import pytest
from catalogue import solved
from matplotlib import rcParams
from matplotlib.image import imread

from compare.figures import animation
from compare.figures.animation import check_format, write_animation
from compare.figures.fields import FieldPicture
from compare.figures.fronts import fronts, moving_parts, reach
from compare.figures.quantities import ALONG_Z, QUANTITIES, find_quantity
from compare.figures.saving import save_figure
from semianalytic import (
    ComputationError,
    IncidentWave,
    MissingLibraryError,
    Scene,
    SceneError,
    Tractions,
    find,
    fringes,
    solve,
)

SCENES = ("preloaded", "tap", "antiplane")


@pytest.fixture(scope="module", params=SCENES)
def solution(request):
    return solved(find(request.param))


def picture(solution, name, points=10):
    """A picture of a quantity at t = 1, of as much as moves until then."""
    quantity = find_quantity(name, solution.scene)
    return FieldPicture(solution, quantity, reach(solution, 1.0), points, 1.0)


def test_names_of_fronts_that_cross_stand_clear_of_each_other():
    """The circle of the P wave meets the front of this SV wave where both have their names."""
    wave = IncidentWave("SV", angle=-30.0, stress=0.2)
    scene = Scene(find("preloaded").material, 0.3, Tractions(1.0, 0.0), wave)
    panel = picture(solve(scene, rtol=1e-4), "sxy", 8).figure.axes[0]
    places = {text.get_text(): text.xy for text in panel.texts}
    assert {"P", "S", "incident SV"} <= set(places)
    x0, x1, y0, y1 = (*panel.get_xlim(), *panel.get_ylim())
    for (combination, (x, y)), (other, (a, b)) in itertools.combinations(places.items(), 2):
        clear = abs(x - a) > 0.1 * (x1 - x0) or abs(y - b) > 0.03 * (y1 - y0)
        assert clear, (combination, other)


@pytest.mark.parametrize(
    ("name", "names"),
    [
        ("preloaded", ["P", "S", "plane S", "head wave", "Mach front"]),
        ("antiplane", ["S", "plane S"]),
        ("pressure-drop", ["P", "S", "plane P", "head wave", "Mach front"]),
    ],
)
def test_fronts_of_scenes_are_all_named(name, names):
    assert [front.name for front in fronts(solved(find(name)), 1.0)] == names


def test_nothing_moves_ahead_of_the_first_circle(solution):
    first = next(fronts(solution, 1.0))
    angle = np.linspace(0.05, 1.5, 7)
    radius = np.hypot(first.x[0], first.y[0])
    for factor, moves in ((1 + 1e-9, False), (0.98, True)):
        x, y = factor * radius * np.cos(angle), factor * radius * np.sin(angle)
        speed = np.linalg.norm(solution.velocity(x, y, 1.0), axis=0)
        assert np.all((speed > 1e-3) == moves)


def test_slope_of_velocity_breaks_at_head_waves_and_mach_fronts(solution):
    """Second differences across a front are far above those on either side of it."""
    step = 1e-4
    for front in fronts(solution, 1.0):
        if front.name not in ("head wave", "Mach front"):
            continue
        middle = len(front.x) // 2
        along = np.array([np.diff(front.x)[middle], np.diff(front.y)[middle]])
        across = step * np.array([along[1], -along[0]]) / np.hypot(*along)
        offsets = np.arange(-30, 31)
        x, y = front.x[middle] + across[0] * offsets, front.y[middle] + across[1] * offsets
        bend = np.abs(np.diff(solution.velocity(x, y, 1.0), 2)).max(axis=0)
        assert abs(int(bend.argmax()) - 29) <= 1, front.name
        assert bend.max() > 5 * np.median(bend)


def test_moving_parts_are_those_of_the_interface():
    (opening,) = moving_parts(solved(find("tap")), 2.0)
    assert opening.kind == "open"
    assert opening.covers(2 * 0.9325)
    first, second = moving_parts(solved(find("preloaded")), 1.0)
    assert (first.kind, first.start) == ("slip", 0.0)
    assert second.covers(1.0)


@pytest.mark.thinned(12)
@pytest.mark.parametrize("name", ["speed", "pressure", "fringes"])
def test_every_kind_of_quantity_has_a_picture_in_its_range(name, solution):
    panel, bar = picture(solution, name, 12).figure.axes
    (image,) = panel.get_images()
    shown = image.get_array()
    assert shown.shape == (12, 12)
    assert np.isfinite(shown).all()
    assert image.norm.vmin <= shown.min()
    assert shown.max() <= image.norm.vmax
    assert bar.get_ylabel() == find_quantity(name, solution.scene).labelled(solution.scene)


def test_every_quantity_has_a_label_and_a_value(solution):
    known = {**QUANTITIES, **(ALONG_Z if solution.scene.antiplane else {})}
    x, y, labels = np.array([0.4, -0.5]), np.array([0.2, -0.3]), set()
    for name in known:
        quantity = find_quantity(name, solution.scene)
        assert np.isfinite(quantity.at(solution, x, y, 1.0)).all()
        labels.add(quantity.labelled(solution.scene))
    assert len(labels) == len(known)


def test_values_are_those_of_the_fields():
    solution = solved(find("preloaded"))
    scene, x, y = solution.scene, np.array([0.4, -0.5]), np.array([0.2, -0.3])
    stress, velocity = solution.stress(x, y, 1.0), solution.velocity(x, y, 1.0)
    for name, expected in (
        ("speed", np.hypot(*velocity)),
        ("pressure", -(stress[0] + stress[1]) / 2),
        ("max-shear", np.hypot((stress[0] - stress[1]) / 2, stress[2])),
        ("fringes", fringes(stress, 4.0, 1.0)),
        ("syy", stress[1]),
        ("uy", solution.displacement(x, y, 1.0)[1]),
    ):
        assert find_quantity(name, scene).at(solution, x, y, 1.0) == pytest.approx(expected), name
    assert find_quantity("fringes", scene, 0.1).at(solution, x, y, 1.0) == pytest.approx(
        fringes(stress, 10.0, 1.0)
    )


def test_antiplane_shear_stress_is_that_along_z():
    solution = solved(find("antiplane"))
    rows = solution.stress(0.4, 0.2, 1.0)
    shown = find_quantity("max-shear", solution.scene)
    seen = shown.at(solution, np.array([0.4]), np.array([0.2]), 1.0)
    assert seen == pytest.approx(np.hypot(rows[3], rows[4]))


@pytest.mark.parametrize(("name", "words"), [("szz", "one of speed"), ("vz", "only antiplane")])
def test_unknown_quantities_are_refused(name, words):
    with pytest.raises(SceneError, match=words):
        find_quantity(name, find("preloaded"))


def test_picture_of_a_window_has_square_cells(tmp_path):
    solution = solved(find("preloaded"))
    quantity = find_quantity("speed", solution.scene)
    figure = FieldPicture(solution, quantity, (-1.0, 1.0, 0.0, 0.5), 40, 1.0).figure
    (image,) = figure.axes[0].get_images()
    assert image.get_array().shape == (10, 40)
    assert {text.get_text() for text in figure.axes[0].texts} <= {"head wave", "S", "Mach front"}
    save_figure(figure, tmp_path / "field.png")
    assert imread(tmp_path / "field.png").std() > 0.05


@pytest.mark.slow
def test_frames_of_a_film_lie_on_one_another():
    film = picture(solved(find("tap")), "pressure")
    place, colours = film.panel.get_position(), film.panel.get_images()[0].get_clim()
    title = film.figure.texts[0].get_window_extent().y0
    film.show(0.2)
    film.figure.draw_without_rendering()
    assert film.panel.get_position().bounds == place.bounds
    assert film.panel.get_images()[0].get_clim() == colours
    assert len(film.figure.legends) == 1
    assert "t = 0.2" in film.figure.get_suptitle()
    assert film.figure.texts[0].get_window_extent().y0 == pytest.approx(title)
    assert film.panel.get_window_extent().y1 < title


def test_interrupted_animation_leaves_nothing(tmp_path):
    def interrupt(done, frames):
        raise KeyboardInterrupt

    still = picture(solved(find("antiplane")), "vz", 6)
    with pytest.raises(KeyboardInterrupt):
        write_animation(tmp_path / "film.gif", still, [0.5, 1.0], interrupt)
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def film(tmp_path, monkeypatch):
    """Makes an MP4 of two frames, an ffmpeg being what a script is; returns its path."""

    def make(script):
        program = tmp_path / "bin" / "ffmpeg"
        program.parent.mkdir()
        program.write_text(f"#!/bin/sh\n{script}\n")
        program.chmod(0o755)
        monkeypatch.setitem(rcParams, "animation.ffmpeg_path", str(program))
        check_format("mp4")
        path = tmp_path / "films" / "film.mp4"
        write_animation(path, picture(solved(find("antiplane")), "vz", 6), [0.5, 1.0])
        return path

    return make


@pytest.mark.slow
def test_ffmpeg_is_given_every_frame(film):
    path = film('for last; do :; done; cat > "$last"')
    frames = np.frombuffer(path.read_bytes(), dtype=np.uint8).reshape(2, -1, 4)
    assert (frames[..., 3] == 255).all()
    assert (frames[0] != frames[1]).any()
    assert [file.name for file in path.parent.iterdir()] == ["film.mp4"]


@pytest.mark.thinned(2)
@pytest.mark.parametrize("script", ["exit 3", "cat > /dev/null; exit 3"])
def test_a_failing_ffmpeg_is_one_sentence(film, script, tmp_path):
    with pytest.raises(ComputationError, match=r"ffmpeg could not write .*take the format gif\.$"):
        film(script)
    assert [path.name for path in tmp_path.iterdir()] == ["bin"]


def test_a_missing_ffmpeg_is_one_sentence(monkeypatch):
    monkeypatch.setattr(animation.FFMpegWriter, "isAvailable", classmethod(lambda cls: False))
    check_format("gif")
    with pytest.raises(MissingLibraryError, match=r"ffmpeg, which is not installed.*gif\.$"):
        check_format("mp4")
