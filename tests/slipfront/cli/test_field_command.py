"""`slipfront field`: what it writes, what it refuses, and how it ends."""

import csv
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from semianalytic import find, solve


@pytest.mark.slow
def test_all_that_can_be_asked_for_is_written(tmp_path, shown):
    asked = "--of vx --animate 2 --vtu --grid 4,4 --gauge 0.4,0.2 --points 8 --samples 5 --quiet"
    first, *lines = shown(f"field preloaded {asked} --output out").out.splitlines()
    written = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert first == "Written to out/:"
    # the frames are those of fields.pvd
    assert sorted(line.split()[0] for line in lines) == [
        name for name in written if not name.endswith(".vtu")
    ]
    assert "vx until then, 2 frames" in lines[1]
    assert "x = 0.4 length, y = 0.2 length" in lines[3]
    assert written == [
        "fields-0001.vtu", "fields-0002.vtu", "fields.pvd",
        "preloaded_gauge-1.csv", "preloaded_gauge-1.png",
        "preloaded_vx.gif", "preloaded_vx.png",
    ]  # fmt: skip


@pytest.mark.slow
def test_a_face_is_told_by_its_sign(tmp_path, undrawn, shown):
    """Records at y = 0 and y = -0 are those of the upper and of the lower face of the slot."""
    gauges = "--gauge=-0.5,0 --gauge=-0.5,-0 --points 4 --samples 3"
    shown(f"field preloaded {gauges} --friction 0.2 --output .")
    upper, lower = (
        np.array(list(csv.reader((tmp_path / name).read_text().splitlines()[2:])), dtype=float)
        for name in ("preloaded_gauge-1.csv", "preloaded_gauge-2.csv")
    )
    first = (tmp_path / "preloaded_gauge-2.csv").read_text().splitlines()[0]
    assert first == (
        "# slipfront field preloaded --friction=0.2 --gauge=-0.5,-0.0 --time=1.0 --samples=3"
    )
    solution = solve(find("preloaded"))
    assert upper[:, 3] == pytest.approx(-lower[:, 3])
    assert upper[-1, 3] != pytest.approx(solution.velocity(-0.5, 0.0, 1.0)[0], rel=1e-4)


@pytest.mark.slow
def test_a_lower_body_of_another_kind_is_solved_and_recorded(
    tmp_path, undrawn, printed, monkeypatch
):
    solved = cache(solve)
    monkeypatch.setattr("slipfront.cli.field_command.solve", solved)
    gauges = "--gauge=0.5,0 --gauge=0.5,-0.2 --points 4 --samples 3 --output ."
    document = printed(f"field preloaded --lower-shear-modulus 2.25 {gauges}")
    pair = document["scene"]
    assert (pair["material"]["shear_modulus"], pair["lower_material"]["shear_modulus"]) == (1, 2.25)
    assert document["units"]["scene"]["lower_material"]["shear_modulus"] == "stress"
    scene = find("preloaded")
    lower = replace(scene.material, shear_modulus=2.25)
    answer = solved(replace(scene, lower_material=lower), method="self-similar")
    for number, y, body in ((1, 0.0, scene.material), (2, -0.2, lower)):
        lines = (tmp_path / f"preloaded_gauge-{number}.csv").read_text().splitlines()
        assert "--lower-shear-modulus=2.25" in lines[0]
        last = dict(zip(lines[1].split(","), map(float, lines[-1].split(",")), strict=True))
        assert last["v_x [length/time]"] == answer.velocity(0.5, y, 1.0)[0]
        sigma = answer.stress(0.5, y, 1.0) - answer.stress(0.5, y, 0.0)
        assert last["eps_xy [1]"] == pytest.approx(sigma[2] / (2 * body.shear_modulus))
    assert document["window"]["x1"] == pytest.approx(1.05 * lower.longitudinal_speed)


def test_results_go_where_those_of_the_scene_are(tmp_path, undrawn, shown):
    shown("field antiplane --of syz --friction 0.6 --points 4")
    (path,) = (tmp_path / "results").rglob("*.png")
    assert path == tmp_path / "results" / "antiplane-friction-0.6" / "field" / "antiplane_syz.png"


@pytest.mark.slow
def test_a_marched_scene_is_drawn(tmp_path, shown):
    shown("field ramp --nodes 60 --points 6 --time 0.5 --output . --quiet")
    assert [path.name for path in tmp_path.iterdir()] == ["ramp_speed.png"]


def test_interruption_leaves_what_is_whole(tmp_path, undrawn, monkeypatch, shown):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("compare.output.field_files.write_frames", interrupt)
    shown("field preloaded --points 4 --vtu --output .", 130)
    assert [path.name for path in tmp_path.iterdir()] == ["preloaded_speed.png"]


def test_gauges_of_a_march_along_a_line_record_what_its_answer_says(tmp_path, undrawn, shown):
    asked = "--time 2 --nodes 400 --points 8 --samples 5 --gauge 4,3 --gauge=-1,-2.5 --output ."
    shown(f"field supershear {asked} --quiet", 4)  # 400 nodes do not resolve it
    run = solve(find("supershear"), end_time=2.0, nodes=400)
    for number, at in ((1, (4.0, 3.0)), (2, (-1.0, -2.5))):
        lines = (tmp_path / f"supershear_gauge-{number}.csv").read_text().splitlines()
        last = dict(zip(lines[1].split(","), map(float, lines[-1].split(",")), strict=True))
        assert last["v_x [length/time]"] == pytest.approx(run.velocity(*at, 2.0)[0])
        assert last["eps_xy [1]"] == pytest.approx(run.strain(*at, 2.0)[2])
    assert "scenes with a slot alone" in shown("field whole-line-patch --points 4", 2).err
