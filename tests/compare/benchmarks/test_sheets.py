"""Problem sheets: the scenes they stand for, in both systems of units."""

import numpy as np
import pytest

from compare.benchmarks.answers import answer_to, content_of
from compare.benchmarks.sheet import SI_SCALES, STATIONS, TIMES, in_si
from compare.benchmarks.sheets import SHEETS, find_sheet
from compare.records.record import QUANTITIES
from semianalytic import march, solve
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.finding import find_scene
from semianalytic.scene.given.overriding import override_scene

SOLVED = [sheet for sheet in SHEETS.values() if not sheet.is_marched]


def test_there_are_ten_and_one_is_marched():
    assert len(SHEETS) == 10
    assert [sheet.name for sheet in SHEETS.values() if sheet.is_marched] == ["pulse"]
    assert all(set(sheet.report) <= set(QUANTITIES) for sheet in SHEETS.values())


@pytest.mark.thinned(12)
@pytest.mark.parametrize("sheet", SOLVED, ids=lambda sheet: sheet.name)
def test_in_si_the_answer_is_the_same_times_scales(sheet):
    plain, si = answer_to(sheet), solve(sheet.si_scene, rtol=1e-12)
    x, t = np.array(STATIONS), np.array(TIMES)[:, None]
    for name in QUANTITIES:
        scaled = SI_SCALES[name] * getattr(plain, name)(x, t)
        theirs = getattr(si, name)(x * SI_SCALES["x"], t * SI_SCALES["t"])
        np.testing.assert_allclose(theirs, scaled, rtol=1e-10, atol=1e-11 * SI_SCALES[name])


def test_in_si_a_pulse_lasts_as_long():
    sheet = SHEETS["pulse"]
    plain, si = march(sheet.scene, 1.0, 100), march(sheet.si_scene, 1.0, 100)
    slip = SI_SCALES["slip"] * plain.slip(0.25, 0.9)
    assert si.slip(0.25 * SI_SCALES["x"], 0.9) == pytest.approx(float(slip), rel=1e-9)


@pytest.mark.parametrize("sheet", SOLVED, ids=lambda sheet: sheet.name)
def test_no_front_passes_a_station_at_a_time_of_the_records(sheet):
    answer = answer_to(sheet)
    ends = [end for zone in (*answer.zones, *answer.openings) for end in (zone.inner, zone.outer)]
    material = sheet.scene.material
    fronts = [*ends, material.rayleigh_speed, material.shear_speed, material.longitudinal_speed]
    speeds = np.array(STATIONS) / np.array(TIMES)[:, None]
    assert np.abs(np.subtract.outer(fronts, speeds)).min() > 1e-5


def test_the_supershear_daughter_is_where_its_sheet_says():
    daughter = content_of(SHEETS["preloaded"], answer_to(SHEETS["preloaded"]))["zones"][1]
    assert daughter[0] == pytest.approx(0.977, abs=5e-4)
    assert daughter[1] == pytest.approx(1.061, abs=5e-4)


def test_a_misspelt_sheet_is_refused_with_a_hint():
    with pytest.raises(SceneError, match="did you mean auxetic"):
        find_sheet("auxetik")
    with pytest.raises(SceneError, match="choose stuck"):
        find_sheet("zzz")


def test_only_scenes_in_plain_units_are_turned_to_si():
    with pytest.raises(SceneError, match="shear modulus and a density of 1"):
        in_si(override_scene(find_scene("preloaded"), density=2.0))
