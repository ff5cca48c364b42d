"""Studies of accuracy and of speed, and their tables."""

from docs.studies.accuracy.scenes import points
from docs.studies.pages import read_data


def test_no_named_scene_differs_anywhere():
    """In the tables of docs/how_we_know.md, which says so; slip of `pulse` is as far off as its
    bar, within a hundredth of it, which decides nothing."""
    _, rows = read_data("scenes-summary")
    assert [row["scene"] for row in rows] == [name for name, _ in points(False)]
    for row in rows:
        assert row["verdict"] == ("unresolved" if row["scene"] == "pulse" else "agrees")
        assert (int(row["agree"]) > 5, int(row["differ"])) == (True, 0)
    _, missed = read_data("scenes-unresolved")
    assert len(missed) == sum(int(row["unresolved"]) for row in rows)
