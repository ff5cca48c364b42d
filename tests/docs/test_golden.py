"""The file that every answer is held against."""

from __future__ import annotations

import numpy as np
import pytest

from docs.studies import golden


def test_all_kinds_of_problems_are_in_it() -> None:
    stored = golden.read(golden.FILE)
    assert list(stored) == golden.labels()
    random = [label for label in stored if label.startswith("random")]
    answered = [label for label in random if "slip" in stored[label]]
    assert len(random) == 280
    assert len(answered) > 240


def test_the_same_answer_shows_no_difference_and_one_bit_shows() -> None:
    before = golden.answered("preloaded")
    assert not list(golden.differences("preloaded", before, golden.answered("preloaded")))
    slip = golden.numbers(before["slip"])
    slip[3] = np.nextafter(slip[3], np.inf)
    (found,) = golden.differences("preloaded", before, before | {"slip": golden.bits(slip)})
    assert "slip differs by" in found
    assert "estimate" in found
    (found,) = golden.differences("preloaded", before, before | {"status": "unresolved"})
    assert "status" in found


@pytest.mark.parametrize("label", ["preloaded", "random scene 3", "random march 1"])
def test_answers_are_those_that_are_stored(label: str) -> None:
    stored, now = golden.read(golden.FILE)[label], golden.answered(label)
    assert now["status"] == stored["status"]
    for name in golden.FIELDS:  # processors round differently
        before = golden.numbers(stored[name])
        np.testing.assert_allclose(
            golden.numbers(now[name]), before, rtol=1e-9, atol=1e-9 * np.abs(before).max()
        )
