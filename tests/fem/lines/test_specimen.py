"""Specimens of finite size: staircases of layers, statics, energy, absorbing sides, half-planes."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import PRELOADED
from json_checks import checked

import slipfront as sf
from compare.comparison.interfaces.specimens import judge_specimen
from fem import Block, Specimen, simulate
from fem.lines.blocks import SIDES
from slipfront.cli.commands import main
from slipfront.loading import load

A, B = sf.Material(1.0, 1.0, 0.25), sf.Material(0.25, 1.0, 0.25)
GUIDED = {"left_side": "guided", "right_side": "guided"}
SIZE = 1 / 50


def layers(shear, history, heights=(1.0, 1.0), lower=A, far="clamped"):
    """Columns of two layers under a pressure of 1, sheared on the top."""
    ends = -2 * SIZE, 2 * SIZE
    top = {"far_side": sf.Tractions(0.0, shear)}
    upper = Block(A, heights[0], *ends, load=top, history=history, **GUIDED)
    return Specimen(
        upper, Block(lower, heights[1], *ends, far, **GUIDED), 0.3, base=sf.Tractions(1.0, 0.0)
    )


def staircase(shear, history, heights, lower, far, end, step=1e-3):
    """Slip of the layers at times 0, step, ... by characteristics, friction of 0.3 times 1."""
    bodies = (lower, heights[1]), (A, heights[0])
    back = {"clamped": 1.0, "free": -1.0, "absorbing": 0.0}[far]
    impedance = [body.shear_impedance for body, _ in bodies]
    delay = [round(height / body.shear_speed / step) for body, height in bodies]
    compliance = sum(1 / ratio for ratio in impedance)
    times = np.arange(round(end / step) + 1) * step
    sent, rate = np.zeros((2, len(times))), np.zeros(len(times))  # u = T - s of each layer
    for n, t in enumerate(times):
        behind = [sent[i, n - 2 * delay[i]] if n >= 2 * delay[i] else 0.0 for i in (0, 1)]
        time = t - delay[1] * step
        load = shear * float(history.mean(time, time + step)) if time >= 0 else 0.0
        below, above = back * behind[0], load - behind[1]
        stuck = 2 * (below / impedance[0] + above / impedance[1]) / compliance
        bears = np.clip(stuck, -0.3, 0.3)
        rate[n] = compliance * (stuck - bears)
        sent[:, n] = bears - below, bears - above
    return np.cumsum(rate) * step


@pytest.mark.parametrize(
    ("shear", "heights", "lower", "far"),
    [
        (0.25, (1.0, 1.0), A, "clamped"),
        (0.4, (1.0, 0.5), A, "absorbing"),
        (0.2, (0.5, 1.0), B, "clamped"),
    ],
)
def test_layers_slip_as_characteristics_say(shear, heights, lower, far):
    """Errors of 0.1 to 1.5 % of the largest slip: damping smears fronts."""
    ramp = sf.Ramp(0.5)
    run = simulate(layers(shear, ramp, heights, lower, far), 12.0, size=SIZE, samples=24)
    exact = staircase(shear, ramp, heights, lower, far, 12.0)
    wanted = np.interp(run.t, 1e-3 * np.arange(len(exact)), exact)
    assert wanted[-1] > 0.4
    assert np.abs(run.slip - wanted[:, None]).max() < 0.02 * wanted[-1]
    assert run.pressure == pytest.approx(1.0, abs=1e-11)


def test_layers_of_a_clamped_pair_stick_first_and_slip_when_the_wave_comes_back():
    """Exact slip after the transits 4 to 9: .28, .68, .76, .76, .88, 1.08."""
    slip = simulate(layers(0.25, sf.Ramp(0.5)), 9.0, size=SIZE, samples=9).slip[:, 2]
    assert slip[:3] == pytest.approx(0.0, abs=1e-12)
    assert slip[3:] == pytest.approx([0.28, 0.68, 0.76, 0.76, 0.88, 1.08], abs=5e-3)


def statics(size, shear=0.0):
    """Pressure and shear in place of blocks 2 x 1, pressed by 1 on top, the bottom clamped."""
    top = {"far_side": sf.Tractions(1.0, shear)}
    pair = Specimen(Block(A, 1.0, -1.0, 1.0, preload=top), Block(A, 1.0, -1.0, 1.0, "clamped"), 0.3)
    x, blocks = pair.meshed(size)
    return x, *pair.in_place(x, blocks)


def test_static_pressure_and_partial_slip_are_those_of_a_saddle_point_solver():
    """Digits of a sparse solution of both blocks and the joint at once."""
    x, pressure, shear = statics(1 / 50)
    assert np.interp([0.0, 0.5, 0.9], x, pressure) == pytest.approx(
        [1.02117, 1.0084, 0.96388], abs=1e-5
    )
    assert np.abs(shear).max() == pytest.approx(0.0107, abs=1e-4)
    _, pressure, shear = statics(1 / 25, 0.2)
    assert (np.abs(shear) > 0.3 * pressure - 1e-9).sum() == 23
    assert (np.abs(shear) < 0.3 * pressure + 1e-9).all()


def test_a_preloaded_specimen_is_at_rest():
    """A patch test: uniform pressure through two materials between rollers."""
    rollers = {"left_side": "roller", "right_side": "roller"}
    upper = Block(A, 1.0, -1.0, 1.0, preload={"far_side": sf.Tractions(1.0, 0.0)}, **rollers)
    run = simulate(
        Specimen(upper, Block(B, 0.5, -1.0, 1.0, "roller", **rollers), 0.3),
        1.0,
        size=0.1,
        samples=3,
    )
    assert run.pressure == pytest.approx(1.0, abs=1e-12)
    assert np.abs(run.slip).max() == np.abs(run.gap).max() == 0.0


def test_energy_balances_whatever_the_sides():
    """Sides of five kinds, two materials, other widths, loads, a slot and separation."""
    draw, opened = np.random.default_rng(1), 0
    for _ in range(12):
        blocks = []
        for _ in range(2):
            kinds = dict(
                zip(
                    ("far_side", "left_side", "right_side"),
                    draw.choice(list(SIDES), 3),
                    strict=True,
                )
            )
            load = {
                name: sf.Tractions(
                    *(0.0 if held else draw.normal() for held in SIDES[str(kind)][:2])
                )
                for name, kind in kinds.items()
            }
            history = [sf.Ramp(0.3), sf.Harmonic(2.0), sf.Step()][draw.integers(3)]
            size = 0.5 + 0.1 * draw.integers(5), -1 - 0.1 * draw.integers(4)
            ends = *size, 1 + 0.1 * draw.integers(4)
            blocks.append(
                Block([A, B][draw.integers(2)], *ends, **kinds, load=load, history=history)
            )
        pair = Specimen(
            *blocks,
            0.4,
            sf.Contact([(-0.55, 2.0)]),
            sf.Tractions(1.0, 0.2),
            sf.Tractions(-0.3, 0.3),
            sf.Ramp(0.2),
        )
        run = simulate(pair, 2.0, size=0.1, samples=5)
        assert abs(run.imbalance) < 1e-13
        opened += run.gap.max() > 1e-6
    assert opened > 6


def test_the_half_plane_answer_holds_until_the_first_reflection():
    """The preloaded scene: c_l = 2, and the top at 0.4 is felt from t = 0.4 on."""
    end, size = 0.38, 1 / 100
    solid = PRELOADED.material
    half = {"height": 0.4, "left": -1.0, "right": 1.0, **GUIDED}
    run = simulate(
        Specimen(
            Block(solid, **half),
            Block(solid, **half),
            PRELOADED.friction,
            sf.Contact.half_line(),
            PRELOADED.base,
            PRELOADED.load,
        ),
        end,
        size=size,
        samples=2,
    )
    x = run.x[(run.x > 0.05) & (run.x < 0.7)]
    exact = sf.solve(PRELOADED).slip(x, end)
    found = run.slip[-1, np.isin(run.x, x)]
    assert np.abs(found - exact).sum() < 0.02 * exact.sum()


@pytest.mark.parametrize("wave", ["P", "S"])
def test_an_absorbing_side_lets_plane_waves_out(wave):
    """Less than 3 % of the traction comes back, as rate of the joint that is stuck."""
    sides = "roller" if wave == "P" else "guided"
    both = {"left_side": sides, "right_side": sides}
    pushed = sf.Tractions(0.1, 0.0) if wave == "P" else sf.Tractions(0.0, 0.1)
    ends = 1.0, -2 * SIZE, 2 * SIZE
    upper = Block(A, *ends, "absorbing", load={"far_side": pushed}, history=sf.Ramp(0.5), **both)
    pair = Specimen(
        upper,
        Block(A, *ends, "absorbing", **both),
        9.0,
        base=sf.Tractions(1.0, 0.0),
        gauges=[(0.0, 0.5)],
    )
    run = simulate(pair, 6.0, size=SIZE, samples=2)
    moving = run.gauges.velocity[-1, 0, 1 if wave == "P" else 0]
    impedance = A.density * (A.longitudinal_speed if wave == "P" else A.shear_speed)
    # a traction on a dashpot and a half-space sends half of it down, which nothing sends back
    assert abs(moving) == pytest.approx(0.05 / impedance, rel=0.01)


TOP = {"far_side": sf.Tractions(1.0, 0.0)}


def pair(upper=None, lower=None, **more):
    usual = {"material": A, "height": 1.0, "left": -1.0, "right": 1.0}
    return Specimen(Block(**usual | (upper or {})), Block(**usual | (lower or {})), 0.3, **more)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Block(A, 0.0, -1.0, 1.0), "height must be positive"),
        (lambda: Block(A, 1.0, 1.0, 1.0), "left must be below right"),
        (lambda: Block(A, 1.0, -1.0, 1.0, "glued"), "far_side must be one of free"),
        (lambda: Block(A, 1.0, -1.0, 1.0, "clamped", load=TOP), "bears no such traction"),
        (lambda: pair({"left": 3.0, "right": 4.0}), "no part of y = 0 in common"),
        (lambda: pair(gauges=[(0.0, 0.0)]), "on the joint or outside"),
        (lambda: pair(gauges=[(0.0, 1.5)]), "on the joint or outside"),
        (lambda: pair(gauges=[0.5]), "gauges must be pairs of numbers"),
        (lambda: pair(gauges=3), "gauges must be pairs of numbers"),
        (lambda: simulate(pair({"preload": TOP}), 1.0, size=0.1), "would fall apart"),
        (lambda: simulate(pair({"height": 1.03}), 1.0, size=0.1), "choose another size"),
    ],
)
def test_what_is_no_specimen_is_one_sentence(make, said):
    with pytest.raises(sf.SceneError, match=said):
        make()


def test_a_named_specimen_is_the_half_plane_until_its_left_side_is_felt():
    """Slip at 4 and 20 mm after 36 us by a prototype: 6.88 and .061 um; 18.1 and 6.34 after 70."""
    run = simulate("pmma-specimen", 70e-6, samples=35)
    at = [int(np.abs(run.x - x).argmin()) for x in (4e-3, 20e-3)]
    assert run.slip[17, at] == pytest.approx([6.88e-6, 0.061e-6], rel=0.03)
    assert run.slip[-1, at] == pytest.approx([18.1e-6, 6.34e-6], rel=0.02)
    assert run.gauges.strain.shape == (run.steps + 1, 3, 3)


FILE = """
friction = 0.3
run = {end_time = 0.5, size = 0.1}
gauges = [[0.0, 0.5]]
[upper]
material = {shear_modulus = 1.0, density = 1.0, poisson_ratio = 0.25}
height = 1.0
left = -1.0
right = 1.0
preload.far_side = {pressure = 1.0, shear = 0.0}
[lower]
material = {shear_modulus = 1.0, density = 1.0, poisson_ratio = 0.25}
height = 1.0
left = -1.0
right = 1.0
far_side = "clamped"
"""


def test_the_command_simulates_a_file_and_keeps_its_answer(tmp_path, capsys):
    path = tmp_path / "plates.toml"
    path.write_text(FILE)
    out = str(tmp_path / "out")
    assert main(["simulate", str(path), "--output", out, "--json"]) == 0
    said = capsys.readouterr()
    document = checked(said.out)
    assert document["files"] == [f"{out}/specimen.h5"]
    assert document["largest_slip"] == 0
    assert "largest slip 0" in said.err
    kept = load(tmp_path / "out" / "specimen.h5")
    assert kept.pressure[-1].max() == pytest.approx(1.02, abs=0.02)
    assert kept.gauges.strain.shape == (kept.steps + 1, 1, 3)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("height = 1.0", "height = 0.0"), "height must be positive"),
        (('"clamped"', '"free"'), "would fall apart"),
        (("[[0.0, 0.5]]", "[[0.0, 5.0]]"), "on the joint or outside"),
        (("[[0.0, 0.5]]", "[['20mm', 0.5]]"), "gauges must be pairs of numbers"),
        (("right = 1.0", "rigth = 1.0"), "did you mean right"),
        (("size = 0.1", "size = 0.3"), "choose another size"),
        (("size = 0.1", "size = 1e-9"), "choose a larger size"),
    ],
)
def test_a_bad_file_is_one_sentence_and_exit_code_2(change, said, tmp_path, refused):
    path = tmp_path / "plates.toml"
    path.write_text(FILE.replace(*change))
    assert said in refused(f"simulate {path} --quiet --output {tmp_path / 'out'}", 2)


@pytest.fixture(scope="module")
def judged():
    """The named specimen, its simulations on three meshes, and when its ends are felt."""
    plates = sf.find_specimen("pmma-specimen")
    judgement = sf.compare(plates, 100e-6, size=1e-3)
    return plates, judgement


def test_a_specimen_agrees_with_half_planes_until_its_ends_are_felt_and_with_meshes_later(judged):
    plates, judgement = judged
    assert judgement.verdict == "agrees"
    # the left side sends a wave at once; three squares of the coarsest mesh are for forerunners
    fastest = plates.upper.material.longitudinal_speed
    assert plates.felt(np.array([0.0, 0.04])) == pytest.approx(np.array([0.1, 0.14]) / fastest)
    assert 0.8 * 0.1 / fastest < judgement.case.until < 0.1 / fastest
    later = [row.name for row in judgement.rows if "meshes" in row.name]
    assert [name.split(" after")[0] for name in later] == ["slip", "slip rate", "shear traction"]


@pytest.mark.parametrize(
    ("fault", "of", "verdict", "row"),
    [
        ("slip_rate", 1.08, "differs", "slip rate against slip"),
        ("shear_traction", 1.01, "differs", "traction beyond friction"),
        ("slip", 1.05, "unresolved", "slip after"),
    ],
)
def test_a_fault_of_the_finest_mesh_after_the_half_planes_is_found(judged, fault, of, verdict, row):
    plates, judgement = judged
    meshes, until = list(judgement.case.whole), judgement.case.until
    factor = np.where(meshes[0].t > 40e-6, of, 1.0)[:, None]
    meshes[0] = replace(meshes[0], **{fault: factor * getattr(meshes[0], fault)})
    found = judge_specimen(plates, meshes, until)
    assert found.verdict == verdict
    assert any(line.name.startswith(row) for line in found.having(verdict))


def test_a_specimen_of_other_friction_differs_from_its_half_planes(judged):
    plates, judgement = judged
    other = replace(plates, friction=0.27)
    assert judge_specimen(other, judgement.case.whole, judgement.case.until).verdict == "differs"


def test_the_ends_of_a_specimen_are_felt_by_the_shortest_way():
    """Sides that plane waves of the load run along leave the edge; loads on sides come directly."""
    at, load = np.array([0.2]), {"contact": sf.Contact.half_line(), "load": sf.Tractions(0.0, 0.1)}
    fastest = A.longitudinal_speed
    assert pair(**load).felt(at) * fastest == pytest.approx(1.2)
    guided = pair(GUIDED, GUIDED, **load).felt(at) * fastest
    assert guided == pytest.approx(1.8)  # by the right side
    low = pair({"height": 0.3, **GUIDED}, GUIDED, **load).felt(at) * fastest
    assert low == pytest.approx(np.hypot(0.6, 0.2))
    assert pair({"load": TOP}).felt(at) * fastest == pytest.approx(1.0)
    assert np.isinf(pair().felt(at))


def test_a_specimen_whose_ends_are_felt_at_once_is_compared_with_no_half_plane():
    pushed = {"load": {"left_side": sf.Tractions(0.1, 0.0)}}
    with pytest.raises(sf.SceneError, match="send waves so early"):
        sf.compare(pair(pushed, base=sf.Tractions(1.0, 0.0)), 1.0, size=0.05)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("solve pmma-specimen", "simulate or compare it"),
        ("simulate pmma-specimen --resolution 9", "is for scenes"),
        ("compare pmma-specimen --nodes 64", "is for scenes"),
        ("simulate preloaded --size 1", "is for specimens"),
        ("compare pmma-specimen --size 0.0006", "its coarsest mesh has squares of 4 times 0.0006"),
    ],
)
def test_commands_that_take_no_specimen_say_so(line, said, refused):
    assert said in refused(line, 2)


def test_a_named_specimen_is_listed_and_written_and_read_again(tmp_path, printed):
    rows = {row["name"]: row for row in printed("scenes")["scenes"]}
    assert rows["pmma-specimen"]["what"] == "specimen"
    printed(f"init {tmp_path}/plates.toml --from pmma-specimen")
    assert sf.find_specimen(tmp_path / "plates.toml") == sf.find_specimen("pmma-specimen")


@pytest.mark.slow
def test_compare_prints_a_specimen(printed):
    document = printed("compare pmma-specimen --quiet")
    assert document["status"] == "agrees"
    assert document["comparison"]["until"] == pytest.approx(32.3e-6, rel=0.01)
