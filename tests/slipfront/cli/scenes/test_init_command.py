"""``slipfront init``: a scene file to start from, which is read back as the scene it is of."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from catalogue import under

from semianalytic import GrowingLoad, PointForce, RateWeakening, SlipWeakening, find, solve
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.named import NAMED_SCENES
from semianalytic.scene.given.template import in_si_units, scene_text
from semianalytic.scene.laws.kinds import LAW_KINDS
from semianalytic.scene.laws.law import follows_path
from semianalytic.scene.tabulated import HISTORY_KINDS
from slipfront.cli.commands import main

X = np.linspace(0.03, 1.2, 40)


def slip(scene):
    """Slip at x when a shear wave has come to 1, over the load over the shear modulus."""
    end, marched = 1 / scene.material.shear_speed, not scene.is_self_similar
    answer = (
        solve(scene, method="space-time", end_time=end, nodes=120, estimate=False)
        if marched
        else solve(scene, method="self-similar")
    )
    off = scene.superposition.taken_off
    load = max(abs(off.pressure), abs(off.shear))
    if isinstance(scene.load, PointForce | GrowingLoad):
        load *= end  # rates of the load
    return answer.slip(X, end) * scene.material.shear_modulus / load


@pytest.mark.thinned(6)
@pytest.mark.parametrize("name", NAMED_SCENES)
def test_what_is_written_is_read_back_and_solved(name, shown):
    for line in (f"init plain.toml --from {name}", f"init si.toml --from {name} --units SI"):
        assert shown(line).out.count("Written to") == 1
    plain, si = find("plain.toml"), find("si.toml")
    assert plain == find(name)
    assert (plain.units, si.units) == ("", "SI")
    assert si.material.shear_speed == 1000.0
    bar = 1e-6 if plain.is_self_similar else 0.01  # a jump may fall behind a step by rounding
    np.testing.assert_allclose(slip(si), slip(plain), atol=bar)


def test_weakening_laws_are_the_same_in_si_units():
    scene = find("preloaded")
    for law in (SlipWeakening(1.0, 0.5, 0.3), RateWeakening(1.0, 0.9, 2.0)):
        weakening = under(scene, law)
        plain, si = (
            solve(entry, method="space-time", end_time=None, nodes=100)
            for entry in (weakening, in_si_units(weakening))
        )
        np.testing.assert_allclose(
            si.interface.slip[-1], 1e-3 * plain.interface.slip[-1], rtol=1e-9, atol=1e-15
        )


@pytest.mark.parametrize("units", ["", "--units SI"])
def test_each_alternative_works_once_its_marks_are_moved(units, shown):
    short, text = (shown(f"init - {units} {every}").out for every in ("", "--all"))
    assert len(short.splitlines()) <= 40
    laws = {kind: law for kind, law in LAW_KINDS.items() if follows_path(law)}
    kinds = {"shear_history": HISTORY_KINDS, "friction_law": laws}
    for table, known in kinds.items():
        before, head, part = text.partition(f"[{table}]")
        part, gap, after = part.partition("\n\n")
        own = [line for line in part.splitlines()[1:] if not line.startswith("# ")]
        for kind in known:
            block = re.search(rf'# kind = "{kind}".*(\n# (?!kind).*)*', part)
            if block is None:
                assert any(f'"{kind}"' in line for line in own)
                continue
            chosen = block[0].replace("\n# ", "\n").removeprefix("# ")
            whole = before + head + "\n" + chosen + gap + after
            Path("mine.toml").write_text(whole)
            scene = find("mine.toml")
            assert type(scene.law if known is laws else scene.shear_history) is known[kind]
            assert f'kind = "{kind}"' in scene_text(scene)


def test_every_number_has_its_unit_and_meaning():
    for units, expected in (("", ("[stress]", "[time]", "[1/time]")), ("SI", ("[Pa]", "[s]"))):
        scene = find("harmonic")
        text = scene_text(in_si_units(scene) if units else scene, with_all=True)
        for measure in expected:
            assert measure in text
        for line in text.splitlines():
            if re.match(r"(# )?\w+ = ", line) and "units" not in line:
                assert re.search(r"= \S.*  # \w", line), line


def test_a_file_that_is_there_stays_unless_forced(tmp_path, refused):
    path = tmp_path / "scene.toml"
    assert main(["init"]) == 0
    path.write_text("mine")
    (tmp_path / "link.toml").symlink_to("nowhere.toml")
    for name in ("", "link.toml"):
        assert "exists already" in refused(f"init {name}")
    assert path.read_text() == "mine"
    assert not (tmp_path / "nowhere.toml").exists()
    assert main(["init", "--force", "--from", "tap"]) == 0
    assert find(str(path)) == find("tap")


def test_places_that_cannot_be_written_are_refused(tmp_path, refused):
    assert "is a folder" in refused(["init", tmp_path])
    (tmp_path / "file").write_text("")
    refused(["init", tmp_path / "file" / "a.toml"], 3)


def test_scenes_of_other_units_are_not_turned():
    scene = find("preloaded")
    other = replace(scene, material=replace(scene.material, density=2.0))
    with pytest.raises(SceneError, match="unit shear modulus and density"):
        in_si_units(other)
    si = in_si_units(scene)
    assert in_si_units(si) is si
