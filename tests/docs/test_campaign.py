"""The random campaign: what it finds, that it finds what is wrong, and that it goes on."""

from dataclasses import replace

import numpy as np
import pytest

from docs.studies.campaign import answers
from docs.studies.campaign import study as campaign
from docs.studies.pages import read_data
from docs.studies.trials.draws import drawn, random_wide_scene
from semianalytic import march, solve
from semianalytic.scene.given.finding import find_scene


def result(lines, what):
    return next(much for name, much in lines if name.startswith(what))


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "scenes", "histories"), [(campaign.SEED, 40, 4), (2, 100, 6)])
def test_a_share_of_the_campaign(seed, scenes, histories):
    """Some scenes and histories of the campaign, and a fiftieth of one of another seed."""
    solved = [campaign.solved_row(seed, index) for index in range(scenes)]
    marched = [campaign.marched_row(seed, index) for index in range(histories)]
    lines = campaign.summary(solved, marched)
    assert result(lines, "not converged") == "0"
    assert result(lines, '"no slip" without a word') == "0"
    for what, most in (
        ("error at 1e-8 over", 1),
        ("traction above friction", 1e-8),
        ("slip against", 1e-8),
        ("strength exceeded", 1e-9),
        ("work gained", 1e-12),
    ):
        assert float(result(lines, what)) < most, what
    _, shown = read_data("campaign")
    assert [row["what"] for row in shown] == [what for what, _ in lines]


def test_it_sees_what_is_wrong(monkeypatch):
    """Friction 3 % off, and a zone left out."""
    scene = find_scene("preloaded")
    exact, other = solve(scene, rtol=1e-11), solve(replace(scene, friction=0.309), rtol=1e-8)
    assert campaign.error_between(solve(scene), exact) < 1e-8
    assert campaign.error_between(other, exact) > 1e-3
    one = replace(exact, zones=exact.zones[:1])
    assert campaign.error_between(one, exact) == np.inf
    monkeypatch.setattr(
        campaign, "solve", lambda scene, rtol: solve(replace(scene, friction=1.03 * scene.friction))
    )
    assert campaign._broken_law(solve(scene), np.random.default_rng(1))[0] < 1e-8
    spoilt = replace(solve(replace(scene, friction=0.309)), scene=scene)
    assert campaign._broken_law(spoilt, np.random.default_rng(1))[0] == pytest.approx(
        0.009, rel=0.01
    )
    weak = replace(march(scene, 1.0, 100), scene=replace(scene, friction=0.29))
    assert campaign._excess(weak) > 0.01


@pytest.mark.slow
def test_it_goes_on_where_it_was(tmp_path, monkeypatch):
    first = campaign.run_campaign(tmp_path, 3, 1)
    table = tmp_path / "solvedrows-1.csv"
    lines = table.read_text().splitlines()
    assert len(lines) == 4
    damaged = lines[2].replace("converged", "convergee").replace("refused", "refusee")
    table.write_text("\n".join([*lines[:2], damaged, lines[3]]) + "\n" + lines[2][:20])
    done, solved_row = [], campaign.solved_row

    def again(seed, index):
        done.append(index)
        return solved_row(seed, index)

    monkeypatch.setattr(campaign, "solved_row", again)
    solved, marched = campaign.run_campaign(tmp_path, 3, 1)
    assert done == [int(lines[2].split(",")[0])]
    for new, old in zip([*solved, *marched], [*first[0], *first[1]], strict=True):
        assert replace(new, seconds=0.0) == replace(old, seconds=0.0) or new.index == done[0]


@pytest.mark.slow
def test_answers_are_held_against_better_ones(tmp_path, monkeypatch):
    """Rows are kept, what is raised is told, and what is spoilt is seen."""
    rows = answers.run_answers(tmp_path, 2, answers.SEED)
    assert [row.index for row in rows] == [0, 1]
    asked = [getattr(row, name) for row in rows for name in answers.QUANTITIES]
    ratios = [ratio for ratio in asked if ratio == ratio]
    assert len(ratios) > 13
    assert max(ratios) < 1
    lines = answers.summary(rows)
    assert lines[0].result == "2"

    def spoilt(scene, rtol):
        friction = scene.friction * (1 + 1e-3 * (rtol > 1e-7))
        return replace(solve(replace(scene, friction=friction), rtol=rtol), scene=scene)

    monkeypatch.setattr(answers, "solve", spoilt)
    assert max(answers.answer_row(answers.SEED, 1).edges, 0) > 1
    monkeypatch.setattr(answers, "solve", lambda *_, **__: 1 / 0)
    assert answers.answer_row(answers.SEED, 1).outcome == "raised ZeroDivisionError"
    monkeypatch.setattr(answers, "answer_row", None)
    again = answers.run_answers(tmp_path, 2, answers.SEED)
    assert [row.outcome for row in again] == [row.outcome for row in rows]


@pytest.mark.slow
def test_processes_share_the_scenes(tmp_path, monkeypatch, capsys):
    """Whatever the order in which rows come; what is known is summed up without more."""
    shared = answers.run_answers(tmp_path, 2, answers.SEED, 2)
    (own,) = answers.run_answers(tmp_path / "alone", 1, answers.SEED)
    assert [row.index for row in shared] == [0, 1]
    assert (shared[0].ratio, shared[0].outcome) == (own.ratio, own.outcome)
    assert max(row.edges for row in shared) < 1
    line = ["answers", "--known", "--output", str(tmp_path), "--csv", str(tmp_path)]
    monkeypatch.setattr("sys.argv", line)
    monkeypatch.setattr(answers, "answer_row", None)
    answers.main()
    assert "--known" in (tmp_path / "campaign-answers.csv").read_text().splitlines()[0]
    assert "scenes drawn" in capsys.readouterr().out
    monkeypatch.setattr("sys.argv", ["answers", "--processes", "0"])
    with pytest.raises(SystemExit, match="2"):
        answers.main()


@pytest.mark.slow
def test_slip_of_the_wrong_sense_is_part_of_the_estimate():
    """Draw 17: its base is at friction, and where 1e-6 lets slip begin at c_l, 1e-8 finds a strip
    of stick, 7e-4 wide, beside which slip is 2e-7 of the largest."""
    scene, _ = drawn(answers.SEED, 17, random_wide_scene)
    rough, fine = solve(scene, rtol=1e-6), solve(scene, rtol=1e-8)
    x = np.linspace(fine.zones[-1].outer, scene.material.longitudinal_speed, 50)
    wrong = -rough.slip_rate(x, 1.0) * rough.zones[-1].sense
    assert rough.zones[-1].outer - fine.zones[-1].outer > 6e-4
    assert 0 < wrong.max() / abs(rough.edge_slip_rate) < rough.error_estimate < 1e-6
    assert campaign.error_between(rough, fine) < rough.error_estimate


FOUND = [
    487,  # no set of zones: antiplane slip that ends ahead of c_R
    560,  # slip, whose largest rate would make eight times as much of it
    939,
    963,  # a film that opens, between its nodes
    pytest.param(823, marks=pytest.mark.slow),  # stress intensity that is a small difference
    pytest.param(
        1351, marks=pytest.mark.slow
    ),  # derivatives of a film that slips at the edge alone
    pytest.param(1522, marks=pytest.mark.slow),  # power of a contact that nearly opens at c_R
]


@pytest.mark.thinned(4)
@pytest.mark.parametrize("index", FOUND)
def test_draws_that_were_beyond_their_estimates(index):
    """One of each kind that a campaign of 5,000 found."""
    row = answers.answer_row(answers.SEED, index)
    assert row.outcome == "converged"
    ratios = [getattr(row, name) for name in answers.QUANTITIES]
    assert max(ratio for ratio in ratios if ratio == ratio) < 1
