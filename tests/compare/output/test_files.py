"""Files are written whole or not at all."""

import pytest

from compare.output.files import write_text
from semianalytic.results.files import new_file
from semianalytic.scene.errors import DataFileError


def test_text_arrives_with_its_folder(tmp_path):
    path = tmp_path / "new" / "folder" / "a.txt"
    write_text(path, "ξ")
    assert path.read_text(encoding="utf-8") == "ξ"
    assert [p.name for p in path.parent.iterdir()] == ["a.txt"]


def test_a_failure_leaves_the_old_file_and_no_rest(tmp_path):
    path = tmp_path / "a.txt"
    write_text(path, "old")

    def fill():
        with new_file(path) as part:
            part.write_text("half")
            raise ValueError("full")

    with pytest.raises(ValueError, match="full"):
        fill()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_in_place_of_a_folder_is_one_clear_error(tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(DataFileError, match=r"Cannot write .*taken"):
        write_text(tmp_path / "taken" / "a.txt", "text")
