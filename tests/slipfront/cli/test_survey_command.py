"""``slipfront survey``: values as they are typed, what is printed, and refusals."""

import shlex

import pytest
import xarray

from semianalytic.parameters.overriding import override_scene
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.finding import find_scene
from slipfront.cli.survey_command import typed_values

GRID = "survey preloaded --friction 0.2,0.9 --poisson-ratio 0.1:0.7:3 --quiet --output a.nc"


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("0.3", 0.3),
        ("0.3,", None),
        ("0.1,0.2,0.5", [0.1, 0.2, 0.5]),
        ("0:1:5", [0, 0.25, 0.5, 0.75, 1]),
        ("-1:1:3", [-1, 0, 1]),
        ("1e-2:1:3:log", [0.01, 0.1, 1]),
        ("0.1:0.9", None),
        ("0.1:0.9:0", None),
        ("0:1:3:log", None),
        ("much", None),
        # with units
        ("2MPa", 2e6),
        ("1 MPa,500kPa", [1e6, 5e5]),
        ("0:4MPa:3", [0, 2e6, 4e6]),
        ("1kPa:1MPa:4:log", [1e3, 1e4, 1e5, 1e6]),
        ("1,4MPa", "--base-shear must have a unit at each number or at none"),
        ("1:nan:3", None),
    ],
)
def test_values_are_read_as_they_are_typed(text, values):
    scene = override_scene(find_scene("preloaded"), units="SI")
    if values is None or isinstance(values, str):
        with pytest.raises(SceneError, match=values or "--base-shear must be a number, a row"):
            typed_values(scene, "base_shear", text, "stress")
    else:
        assert typed_values(scene, "base_shear", text, "stress") == pytest.approx(values, rel=1e-12)


def test_a_survey_in_si_units(shown, printed):
    shown("init steel.toml --material steel")
    line = "survey steel.toml --load-shear 4MPa:5MPa:2 --friction 30% --x 5cm --t 20us,30us"
    more = "--end-time 40us --vary base.pressure=5MPa --output a.nc --quiet"
    document = printed(f"{line} {more}")
    assert document["parameters"]["load_shear"] == {"least": 4e6, "largest": 5e6, "count": 2}
    assert document["units"]["variables"]["slip_rate"] == "m/s"
    with xarray.open_dataset("a.nc", engine="h5netcdf") as data:
        assert data.x.values.tolist() == [0.05]
        assert data.t.values == pytest.approx([2e-5, 3e-5], rel=1e-12)


def test_a_survey_is_written_and_summed_up(shown, monkeypatch):
    monkeypatch.setattr("sys.argv", ["/bin/slipfront", *GRID.split()])
    said = shown(GRID).out
    for words in ("6 points", "converged", "Written to a.nc"):
        assert words in said
    with xarray.open_dataset("a.nc", engine="h5netcdf") as data:
        assert data.status.dims == ("poisson_ratio", "friction")
        assert shlex.split(data.attrs["command"]) == ["slipfront", *GRID.split()]
        assert (data.status.sel(poisson_ratio=0.7).values != "converged").all()


def test_lists_and_marches_from_the_command_line(printed):
    line = "survey ramp --together --friction 0.1,0.3 --base-pressure 1:2:2 --nodes 40"
    document = printed(f"{line} --end-time 0.6 --output a.nc")
    assert document["methods"] == {"space-time": 2}
    assert document["dimensions"]["point"] == 2
    assert document["units"]["variables"]["largest_slip"] == "length"
