"""Comparisons of scenes without slip, without load, without friction: reports that are right."""

import json
from dataclasses import replace

import numpy as np
import pytest
from catalogue import solved
from compare_cases import sampled_run

from compare import judge
from compare.comparison.documents import json_text, solution_document
from compare.comparison.judgement import side_by_side
from compare.comparison.prediction import predict_before, predict_like
from compare.comparison.report import report_document
from compare.comparison.rows import shown_number
from compare.comparison.scales import slip_rate_scale, stress_scale
from compare.figures.histories import comparison_figures
from fem import simulate
from semianalytic.parameters.overriding import override_scene
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.documents import scene_from_document
from semianalytic.scene.given.named import NAMED_SCENES
from slipfront.cli.compare_command import write_comparison

STEEL = {"shear_modulus": 80e9, "density": 7800.0}
SI = {"base_pressure": 1e6, "load_shear": 1e6, **STEEL}
SCENES = {
    "frictionless": ("preloaded", {"friction": 0.0}),
    "frictionless, reversed": ("preloaded", {"friction": 0.0, "load_shear": -1.0}),
    "frictionless in SI": ("preloaded", {"friction": 0.0} | SI),
    "auxetic and frictionless": ("auxetic", {"friction": 0.0}),
    "without pressure": ("preloaded", {"base_pressure": 0.0}),
    "frictionless remote shock": ("remote-shock", {"friction": 0.0}),
    "slip ahead of all waves": ("remote-shock", {"friction": 0.5}),
    "no load": ("preloaded", {"load_shear": 0.0}),
    "no load, no pressure": ("preloaded", {"load_shear": 0.0, "base_pressure": 0.0}),
    "no load in SI": ("preloaded", SI | {"load_shear": 0.0}),
    "small load": ("preloaded", {"load_shear": 0.001}),
    "much friction": ("preloaded", {"friction": 5.0}),
    "more friction": ("preloaded", {"friction": 20.0}),
    "most friction": ("preloaded", {"friction": 1e3}),
    "pressure drop held": ("pressure-drop", {"friction": 20.0}),
}


def scene_of(name):
    source, overrides = SCENES[name]
    return override_scene(NAMED_SCENES[source].scene, **overrides)


def end_time(scene):
    return 1 / scene.material.shear_speed


def finite_everywhere(text):
    """The document in a JSON text; fails on what JSON does not know."""
    return json.loads(text, parse_constant=pytest.fail)


def faultless(solution, resolution):
    return sampled_run(solution, resolution, end_time=end_time(solution.scene))


QUICKLY = ("frictionless", "no load", "small load", "much friction", "most friction")


NOTHING_SHOWN = ("much friction",)
"""Scenes whose mesh shows no zone of slip, and tractions no closer than a tenth."""


@pytest.mark.thinned(10)
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[] if name in QUICKLY else pytest.mark.slow) for name in SCENES],
)
def test_a_run_without_error_agrees(name):
    solution = solved(scene_of(name))
    judgement = judge(solution, faultless(solution, 100))
    assert judgement.verdict == ("unresolved" if name in NOTHING_SHOWN else "agrees")
    assert judgement.counts["differs"] == 0
    document = finite_everywhere(json_text(report_document(judgement, name)))
    assert len(document["rows"]) == len(judgement.rows)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["frictionless", "no load", "most friction"])
def test_figures_of_next_to_nothing_have_finite_limits(name):
    solution = solved(scene_of(name))
    case = side_by_side(solution, faultless(solution, 30))
    for draw in comparison_figures(case).values():
        for panel in draw(case).axes:
            assert np.isfinite([*panel.get_xlim(), *panel.get_ylim()]).all()


def wrong_by(run, share):
    """A run, and its companions, with a share of the units added to each field."""
    history, scene = run.interface, run.scene
    rate, stress = share * slip_rate_scale(scene), share * stress_scale(scene)
    return replace(
        run,
        interface=replace(
            history,
            slip=history.slip + rate * run.end_time,
            slip_rate=history.slip_rate + rate,
            shear_traction=history.shear_traction + stress,
        ),
        final_path=run.final_path + rate * run.end_time,
        final_work_density=run.final_work_density + rate * stress * run.end_time,
        companion=run.companion and wrong_by(run.companion, share),
    )


LARGEST = {
    "frictionless": {"shear traction, largest"},
    "frictionless in SI": {"shear traction, largest"},
    "no load": {"slip rate, largest", "slip, largest", "slip rate over (x, t), largest"},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["frictionless", "frictionless in SI", "no load", "most friction"])
def test_what_is_simulated_where_nothing_is_predicted_differs(name):
    """Wrong by 2e-3 of the units: each of the rows that replace relative errors says so."""
    solution, share = solved(scene_of(name)), 2e-3
    judgement = judge(solution, wrong_by(faultless(solution, 60), share))
    largest = {row.name: row for row in judgement.rows if row.name.endswith("largest")}
    assert set(largest) >= LARGEST.get(name, {"slip rate over (x, t), largest"})
    for row in largest.values():
        expected = share**2 if row.kind == "work" else share
        assert row.difference == pytest.approx(expected, rel=1e-3)
        assert row.verdict == "differs"
        assert not row.relative


@pytest.mark.thinned(2)
@pytest.mark.parametrize(("share", "verdict"), [(0.9e-6, "agrees"), (1.6e-6, "differs")])
def test_what_is_less_than_nothing_agrees_with_nothing(share, verdict):
    solution = solved(scene_of("no load"))
    rows = judge(solution, wrong_by(faultless(solution, 30), share)).rows
    (row,) = (row for row in rows if row.name == "slip rate, largest")
    assert (row.at_nodes, row.verdict) == (0.0, verdict)
    assert row.simulated == row.difference == pytest.approx(share)


def test_numbers_of_a_table_keep_their_digits_whatever_their_size():
    values = (None, 0.0, 0.5, -2.0, 1e-6, -2.3456e-5, 3202.5)
    written = ["—", "0", "0.5000", "-2.000", "1.000e-06", "-2.346e-05", "3202"]
    assert [shown_number(value) for value in values] == written
    assert shown_number(0.012345, digits=3) == "0.0123"


def test_json_has_null_for_what_is_not_finite():
    solution = replace(solved("stuck"), error_estimate=np.inf)
    assert finite_everywhere(json_text(solution_document(solution)))["error_estimate"] is None
    numbers = {"a": [np.nan, np.float64(-np.inf), (1, np.int64(2))], "b": {"c": np.float32(0.5)}}
    assert finite_everywhere(json_text(numbers)) == {"a": [None, None, [1, 2]], "b": {"c": 0.5}}


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    "command",
    [
        "preloaded --friction 0",
        "preloaded --load-shear 0",
        "harmonic --friction 1",
        "preloaded --friction 20",
        "preloaded --load-shear 0.001",
        "harmonic --friction 0",
        "ramp --friction 50",
        "preloaded --friction 0 --method space-time",
    ],
)
def test_every_comparison_ends_in_a_report(command, tmp_path, shown):
    resolution = "40" if "harmonic" in command else "20"  # the coarsest that follows the load
    options = f"--resolution {resolution} --no-snapshots --quiet --all --output out"
    said = shown(f"compare {command} {options}")
    document = finite_everywhere((tmp_path / "out" / "report.json").read_text())
    assert document["verdict"] != "differs"
    assert document["rows"]
    assert said.err == ""
    for row in document["rows"]:
        assert row["name"] in said.out
        if row["simulated"] is None:
            assert row["verdict"] != "agrees"


def random_document(rng):
    """A scene of extremes as a document: nothing, little and much of everything."""
    si = rng.random() < 0.25
    stress, modulus, density = (1e6, 80e9, 7800.0) if si else (1.0, 1.0, 1.0)
    friction = float(rng.choice([0, 1e-9, 1e-3, 0.1, 0.3, 1, 5, 20, 1e3]))
    pressure = float(rng.choice([0, 1, 1, 1]))
    load_pressure, load_shear = rng.choice(
        [[0, 1], [0, -1], [0, 1e-3], [0, 0], [0.5, 0], [0.5, 0.5], [1, 1e-6], [0, 100]]
    )
    shear = float(rng.choice([0, 0, 0.5, -1])) * friction * pressure
    time = (density / modulus) ** 0.5
    document = {
        "friction": friction,
        "material": {
            "shear_modulus": modulus,
            "density": density,
            "poisson_ratio": float(rng.choice([-0.5, 0, 0.25, 1 / 3, 0.45])),
        },
        "base": {"pressure": pressure * stress, "shear": shear * stress},
        "load": {"pressure": float(load_pressure) * stress, "shear": float(load_shear) * stress},
    }
    histories = [
        {"kind": "ramp", "rise_time": 0.3 * time},
        {"kind": "pulse", "duration": 0.6 * time, "shape": "triangle"},
        {"kind": "harmonic", "frequency": 1.5 / time},
        {"kind": "tabulated", "t": [2 * time, 3 * time], "value_at_t": [0.0, 1.0]},
    ]
    for name in ("pressure_history", "shear_history"):
        if rng.random() < 0.25:
            document[name] = histories[rng.integers(len(histories))]
    return document


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(24))
def test_random_extremes_end_in_a_report(seed, tmp_path):
    """Scenes that the solvers take; the others end in a sentence (test_fuzz.py)."""
    rng = np.random.default_rng(seed)
    while True:
        try:
            scene = scene_from_document(random_document(rng))
            predict_before(scene)
            simulation = simulate(scene, resolution=30)
            prediction = predict_like(simulation)
        except SceneError:
            continue
        break
    judgement = judge(prediction, simulation)
    assert judgement.rows
    write_comparison(judgement, "random", tmp_path)
    finite_everywhere((tmp_path / "report.json").read_text())
