"""The evidence page: self-contained, complete, whole or not at all."""

from __future__ import annotations

import base64
import json
import re
from dataclasses import replace
from html import escape
from html.parser import HTMLParser
from io import BytesIO
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

from compare.comparison.rows import AGREES, DIFFERS, UNRESOLVED, Row, shown_number
from compare.studies.evidence import film as evidence_film
from compare.studies.evidence import page as evidence_page
from compare.studies.evidence import study as evidence_study
from compare.studies.evidence.figures import FRAMES, LARGEST, energy_unit, profiles
from compare.studies.evidence.scene import counts_text, energy_tables, scene_section
from compare.studies.evidence.study import (
    FEM,
    PUBLISHED,
    collect,
    collect_scene,
    differences,
    excess,
    worst_row,
)
from semianalytic import Marched, Solution, solve
from semianalytic.scene.errors import SceneError
from slipfront.cli.commands import main

pytestmark = pytest.mark.slow

VOID = {"meta", "link", "img", "input", "br", "hr"}
SCENES = ("remote-shock", "pulse")
OPENING = """friction = 0.3
material = {shear_modulus = 1.0, density = 1.0, poisson_ratio = 0.33}
base = {pressure = 1.0, shear = 0.0}
load = {pressure = -1.0, shear = 0.0}
pressure_history = {kind = "ramp", rise_time = 0.1}
"""
"""A scene that no method but the finite elements answers."""


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """One self-similar scene with the published algorithm, one marched, one that opens."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(evidence_study, "QUICK_ARTICLE_RESOLUTION", 20)
        path = tmp_path_factory.mktemp("scenes") / "lift-off.toml"
        path.write_text(OPENING)
        return collect((*SCENES, str(path)), quick=True, resolution=40)


@pytest.fixture(scope="module")
def text(found):
    """The page, with films of three frames."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(evidence_film, "SHOTS", 3)
        return evidence_page.page(found)


@pytest.fixture(scope="module")
def film(text):
    """What the slider of the film is given."""
    section = text[text.index('<section id="field"') :]
    data = re.search(r'<script type="application/json">(.*?)</script>', section, re.DOTALL)
    return json.loads(data[1])


def picture_of(source):
    data = base64.b64decode(source.removeprefix("data:image/png;base64,"))
    return np.asarray(Image.open(BytesIO(data)).convert("RGB")).astype(int)


def test_frames_of_the_film_are_those_of_its_times(film, text):
    assert film["captions"] == [
        "t = 0.333 T = 0.3333 [time]",
        "t = 0.667 T = 0.6667 [time]",
        "t = 1.000 T = 1 [time]",
    ]
    pictures = [picture_of(source) for source in film["frames"]]
    assert len({picture.shape for picture in pictures}) == 1
    for earlier, later in pairwise(pictures):
        assert (np.abs(later - earlier).max(axis=2) > 30).mean() > 0.05
    assert f'<img src="{film["frames"][-1]}"' in text
    assert 'value="2" aria-valuetext="t = 1.000 T = 1 [time]"' in text


def test_films_are_of_a_solved_and_of_a_marched_scene(found):
    """Not of the one without a semi-analytic answer; if quick, of the first alone."""
    chosen = evidence_film.films(replace(found, quick=False))
    assert [film.evidence for film in chosen] == list(found.scenes[:2])
    assert [type(film.fields) for film in chosen] == [Solution, Marched]
    assert [film.evidence for film in evidence_film.films(found)] == [found.scenes[0]]
    assert evidence_film.films(replace(found, scenes=found.scenes[2:])) == []


NAME = "\"'--></script><script>alert(1)</script><img src=x onerror=alert(1)><!--<script>"
"""A name that a scene file of somebody else may have."""


def test_names_of_scenes_are_text(found, text, outline):
    named = [replace(scene, source=f"{NAME}/{NAME}.toml") for scene in found.scenes]
    named[-1] = replace(named[-1], obstacle=NAME)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(evidence_film, "SHOTS", 3)
        shown = evidence_page.page(replace(found, scenes=tuple(named)))
    attacked = parsed(shown)
    assert [image["src"] for image in attacked.images] == [image["src"] for image in outline.images]
    assert attacked.ids == outline.ids
    assert shown.count("<script") == text.count("<script")
    assert escape(NAME) in shown


class Outline(HTMLParser):
    """Checks that tags balance; notes identifiers, references, headings, rows and captions."""

    def __init__(self):
        super().__init__()
        self.open, self.ids, self.references, self.headings = [], [], [], []
        self.images, self.labels, self.tables = [], [], 0

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.ids += [values["id"]] if "id" in values else []
        self.references += [values[key] for key in ("src", "href") if key in values]
        self.labels += [values["for"]] if tag == "label" and "for" in values else []
        self.images += [values] if tag == "img" else []
        self.headings += [tag] if re.fullmatch("h[1-6]", tag) else []
        self.tables += tag == "table"
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def parsed(page):
    """The outline of a page, all of whose tags are closed."""
    outline = Outline()
    outline.feed(page)
    outline.close()
    assert outline.open == []
    return outline


@pytest.fixture(scope="module")
def outline(text):
    return parsed(text)


def test_page_needs_no_other_file(outline, text):
    inside = ("#", "data:")
    assert [found for found in outline.references if not found.startswith(inside)] == []
    assert not re.search(r"<link (?!rel=\"icon\")|<script src|@import|url\((?!#)|fetch\(", text)
    assert set(re.findall(r"https?://[^\"' <]+", text)) == {"http://www.w3.org/2000/svg"}


def test_anchors_are_unique_and_lead_somewhere(outline):
    assert len(set(outline.ids)) == len(outline.ids)
    anchors = {found[1:] for found in outline.references if found.startswith("#")}
    assert anchors <= set(outline.ids)
    assert set(outline.labels) <= set(outline.ids)


def test_headings_descend_by_one_and_images_have_words(outline):
    levels = [int(tag[1]) for tag in outline.headings]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert max(np.diff(levels)) == 1
    assert outline.images
    for image in outline.images:
        assert len(image["alt"]) > 20
        data = base64.b64decode(image["src"].removeprefix("data:image/png;base64,"))
        assert data.startswith(b"\x89PNG")


def test_every_scene_row_and_claim_is_on_the_page(found, text):
    plain = re.sub(r"<[^>]+>", "\n", text)
    for scene in found.scenes:
        assert f"Scene: {scene.label}" in plain
        for _, row in scene.rows:
            assert f"\n{row.label.replace('<', '&lt;').replace('>', '&gt;')}\n" in plain
            assert row.obstacle in plain
    for verdict, shown in ((AGREES, AGREES), (UNRESOLVED, UNRESOLVED), (DIFFERS, DIFFERS.upper())):
        rows = sum(row.verdict == verdict for scene in found.scenes for _, row in scene.rows)
        scenes = sum(scene.verdict == verdict for scene in found.scenes if scene.judgements)
        assert found.counts[verdict] == rows
        assert text.count(f">{shown}</td>") == rows + scenes
    assert counts_text(found.counts) in plain
    assert found.counts.total() == sum(len(scene.rows) for scene in found.scenes) > 30
    for claim in found.claims:
        assert claim.text.replace("<", "&lt;").replace(">", "&gt;") in plain
    for name, value in found.stamp.items():
        assert f"{name}\n" in plain
        assert value in plain
    for command in ("slipfront compare pulse --resolution 40", "slipfront simulate /"):
        assert command in plain


def test_methods_are_those_that_apply(found):
    shock, pulse, opens = found.scenes
    assert shock.methods == ("self-similar", "space-time", FEM, PUBLISHED)
    assert pulse.methods == ("space-time", FEM)
    assert opens.methods == (FEM,)
    assert "turn tensile" in opens.obstacle  # of the march
    assert worst_row(opens) is None
    assert opens.simulation.companion is None  # nothing to be judged by it
    with pytest.raises(SceneError, match="does not apply"):
        pulse.published_rate()


def test_a_step_that_opens_the_contact_is_judged_without_a_march():
    """An opening 0.19 c_t T wide: a resolution of 40 has fewer than 8 elements for it."""
    verdicts = {}
    for resolution in (40, 60):
        (opens,) = collect(("lift-off",), quick=True, resolution=resolution).scenes
        assert opens.methods == ("self-similar", FEM)
        verdicts[resolution] = opens.verdict
    assert verdicts == {40: "unresolved", 60: "agrees"}


def test_a_scene_from_a_file_that_slips_everywhere(tmp_path):
    path = tmp_path / "all & more.toml"
    path.write_text(
        "friction = 0.5\nmaterial = {shear_modulus = 1.0, density = 1.0, poisson_ratio = 0.25}\n"
        "base = {pressure = 0.0, shear = 0.0}\nload = {pressure = 1.0, shear = 1.0}\n"
        'load_on = "remote"\n',
        encoding="utf-8",
    )
    scene = collect_scene(str(path), resolution=20)
    assert (scene.label, scene.summary) == ("all & more", f"from {path}")
    shown = scene_section("scene-1", scene, quick=True)
    assert shown.count("∞") == 2  # outer edge of the zone, and frictional work
    assert escape(f"slipfront compare '{path}'") in shown
    parsed(shown)


def test_independent_methods_agree_and_the_published_one_does_not(found):
    gaps = differences(found.scenes[0])
    assert gaps["space-time"][0] < 0.005
    assert gaps[FEM][0] < 0.01
    assert gaps[PUBLISHED][0] > 0.1


def test_all_methods_agree_with_the_closed_forms(found):
    """At 40 elements per c_t T; the self-similar method to its default tolerance."""
    slow, everywhere, frictionless = found.closed_forms
    assert slow.edge == pytest.approx(0.375)
    assert slow.solved_edge == pytest.approx(slow.edge, abs=1e-8)
    assert everywhere.solved_edge is None
    for form in (slow, everywhere, frictionless):
        assert form.errors["self-similar"] < 1e-7
        assert form.errors["space-time"] < 0.03
        assert form.errors[FEM] < 0.06


def test_profiles_are_those_of_the_histories(found):
    """What the slider draws, to a two-thousandth of its panel, clipped far outside it."""
    scene = found.scenes[1]
    data = profiles("a", scene)
    assert len(data["t"]) == FRAMES
    rate, traction = data["panels"]
    assert [curve["method"] for curve in rate["curves"]] == [FEM, "space-time"]
    assert [curve["bound"] for curve in traction["curves"]] == [False, False, True, True]
    curve = rate["curves"][0]
    history = scene.histories[FEM]
    level = int(np.argmin(np.abs(history.t / history.t[-1] - data["t"][20])))
    expected = history.slip_rate[level] / 2  # V₀ of unit loads in a unit solid
    got = curve["unit"] * np.array(curve["values"][20])
    clipped = np.abs(curve["values"][20]) == LARGEST
    assert np.abs(got - expected)[~clipped].max() < curve["unit"]


def test_a_row_shows_its_three_values_its_bar_and_what_would_resolve_it(found, text):
    """Every cell of a row, in order; the remedy with its mesh behind the obstacle."""
    judgement = found.scenes[0].judgements[0]
    row = next(row for row in judgement.rows if row.verdict == UNRESOLVED and row.resolution)
    cells = [
        *map(shown_number, (row.exact, row.at_nodes, row.simulated)),
        *(row.shown_share(row.difference), row.shown_share(row.bar), UNRESOLVED),
        f"{row.obstacle}; {judgement.remedy(row)}",
    ]
    line = next(line for line in text.splitlines() if f">{row.label}</th>" in line)
    assert re.sub(r"(<[^>]+>)+", "|", line).strip("|").split("|") == [row.label, *cells]


def test_judgements_share_one_simulation_and_its_companions(found):
    """Both methods of a scene are judged by the same runs, made once."""
    scene = found.scenes[0]
    runs = [scene.simulation, *(judgement.simulation for judgement in scene.judgements)]
    assert len(runs) == 3
    for one in (runs, [run.companion for run in runs], [run.companion.companion for run in runs]):
        assert len({id(run.interface) for run in one}) == 1
    assert [run.resolution for run in scene.coarser] == [20, 10]


@pytest.mark.parametrize(
    ("simulated", "difference", "bar", "obstacle", "expected"),
    [
        (0.98, -0.02, 0.04, "", 0.5),
        (None, None, 0.04, "", np.inf),
        (0.5, -0.5, 0.04, "too coarse", 0.0),
        (0.98, -0.02, None, "", 0.0),
        (1.0, 0.0, 0.0, "", 0.0),
        (0.98, -0.02, 0.0, "", np.inf),
    ],
)
def test_excess_is_the_difference_over_the_bar(simulated, difference, bar, obstacle, expected):
    row = Row("a", "slip", None, 1.0, simulated, difference, bar, obstacle=obstacle)
    assert excess(row) == pytest.approx(expected)


def test_the_worst_row_is_a_resolved_one(found):
    """The nearest to its bar, or farthest beyond it, of those that a verdict is given on."""
    for scene in found.scenes[:2]:
        _, worst = worst_row(scene)
        assert worst.verdict != UNRESOLVED
        resolved = [row for _, row in scene.rows if row.verdict != UNRESOLVED]
        assert excess(worst) == max(map(excess, resolved)) > 0


def test_figures_of_other_studies_are_taken_from_files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(evidence_page, "CHECKOUT", tmp_path)
    study = evidence_page.STUDIES["stability"]
    assert "Not drawn" in evidence_page._earlier(study)
    folder = tmp_path / "results" / "stability"
    folder.mkdir(parents=True)
    (folder / "fem-stability.png").write_bytes(b"\x89PNG of a test")
    shown = evidence_page._earlier(study)
    drawn = base64.b64encode(b"\x89PNG of a test").decode()
    for words in (drawn, "Drawn earlier", "slipfront stability --solver --fem --space-time"):
        assert words in shown


def test_unknown_scenes_and_folders_as_output_are_refused_in_one_sentence(tmp_path, refused):
    path = tmp_path / "page.html"
    assert "did you mean preloaded?" in refused(["evidence", "preload", "--output", path])
    assert not path.exists()
    assert "is a folder" in refused(["evidence", "stuck", "--output", tmp_path])


def differing(evidence):
    """The evidence with one row of one scene that differs."""
    first, *others = evidence.scenes
    judgement, *rest = first.judgements
    row = replace(judgement.rows[0], simulated=9.0, difference=9.0, bar=0.1, obstacle="")
    judgement = replace(judgement, rows=(row, *judgement.rows[1:]))
    first = replace(first, judgements=(judgement, *rest))
    return replace(evidence, scenes=(first, *others))


@pytest.mark.parametrize("differs", [False, True])
def test_command_writes_the_page_and_tells_by_its_exit_code(
    found, text, tmp_path, monkeypatch, capsys, differs
):
    asked = {}

    def stand_in(sources, **options):
        asked.update(options, sources=sources)
        return differing(found) if differs else found

    monkeypatch.setattr(evidence_page, "collect", stand_in)
    monkeypatch.setattr(evidence_page, "page", lambda _: text)
    path = tmp_path / "new" / "page.html"
    code = main(["evidence", *SCENES, "--quick", "--quiet", "--output", str(path)])
    assert found.counts[DIFFERS] == 0
    assert code == (1 if differs else 0)
    assert asked["sources"] == list(SCENES)
    assert asked["quick"]
    assert path.read_text(encoding="utf-8") == text
    assert str(path) in capsys.readouterr().out.replace("\n", "")


@pytest.mark.parametrize("stage", ["collect", "page"])
def test_interruption_leaves_nothing_half_written(stage, found, tmp_path, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(evidence_page, "collect", lambda *_, **__: found)
    monkeypatch.setattr(evidence_page, stage, interrupted)
    path = tmp_path / "page.html"
    path.write_text("earlier", encoding="utf-8")
    assert main(["evidence", "stuck", "--quiet", "--output", str(path)]) == 130
    assert path.read_text(encoding="utf-8") == "earlier"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["pressure-drop", "auxetic"])
def test_all_of_the_contact_takes_more_than_a_part_of_it(name):
    scene = collect_scene(name, resolution=20)
    shown = energy_tables(scene)
    work = shown[shown.index("Frictional work until T") :]
    row = re.search(r"self-similar.*?(\d\.\d{6}).*?(\d\.\d{6})", work, re.DOTALL)
    part, whole = map(float, row.groups())
    assert 0 < part <= whole
    heat = solve(scene.scene, rtol=1e-10).frictional_work(scene.simulation.end_time)
    assert whole == pytest.approx(float(heat) / energy_unit(scene), abs=1e-6)


def test_the_figures_of_this_checkout_are_found():
    """The studies are drawn in docs/figures of the repository, wherever one stands."""
    assert (evidence_page.CHECKOUT / "docs" / "figures" / "wear.png").is_file()
