"""Runs that were interrupted go on to the last bit, with their own interface alone."""

import signal
from dataclasses import replace

import numpy as np
import pytest

import semianalytic as sf
from docs.studies.lines import scene_along
from semianalytic.engine.march import march

UNIT = sf.Material(1.0, 1.0, 0.25)
COULOMB = sf.Coulomb(0.5)
FIELDS = ("t", "slip", "slip_rate", "shear_traction", "state", "pressure", "gap")


def weakening_fault():
    law = sf.RateAndState(
        0.01, lambda x: 0.004 + 0.012 * (np.abs(x) < 2), 0.6, 1e-6, 1e-6, theta=1.3
    )
    rock = sf.Material(20e9, 2222.2, 0.25)
    return scene_along(rock, law, 16.0, 5e6, 3e6, rate=1e-6, plate_rate=1e-6, held=32.0, even=True)


def jumping():
    patch = sf.InterfaceLoad(lambda x: 1.0 * (abs(x) < 1), history=sf.Pulse(2.0, "rectangle"))
    return scene_along(UNIT, sf.Coulomb(0.3), 16.0, shear=0.1, loads=[patch])


def opening_fault(size=-3.0):
    """A burst of tension opens it, and it closes again within 3."""
    load = sf.InterfaceLoad(
        pressure=lambda x, t: size * np.exp(-2 * x**2 - 4 * (t - 1.5) ** 2), history=None
    )
    law = sf.SlipWeakening(0.3, 0.1, 0.5)
    return scene_along(UNIT, law, 16.0, 1.0, shear=0.15, loads=[load])


def glued_fault(strength=1.0):
    load = sf.InterfaceLoad(pressure=lambda x: -2.5 * np.exp(-(x**2)))
    bonds = sf.Adhesion(strength, 0.3)
    return scene_along(UNIT, sf.Coulomb(0.3), 8.0, 0.5, loads=[load], adhesion=bonds)


def two_bodies():
    """Rock on a faster body, over-stressed on half of a contact between slots."""
    load = sf.InterfaceLoad(lambda x: 0.08 * (abs(x) < 2.5))
    contact, lower = sf.Contact([(-4.0, 4.0)]), sf.Material(2.25, 1.0, 0.25)
    given = {"pressure": 1.0, "shear": 0.16, "loads": [load], "lower_material": lower}
    return scene_along(UNIT, sf.Coulomb(0.2), 10.0, contact=contact, **given)


def moved_grid(begin=-2.03):
    """The grid lies where both ends of the contact are as close to their places as can be."""
    loads, strip = [sf.InterfaceLoad(0.2)], sf.Contact([(begin, 1.9)])
    return scene_along(UNIT, sf.Coulomb(0.1), 20.0, contact=strip, loads=loads)


def forced_front():
    law = sf.ForcedFront(0.6, 0.2, arrival=lambda x: np.abs(x), fall=0.5)
    return scene_along(UNIT, law, 8.0, shear=0.4, even=True, mode="antiplane")


def struck(since=0.5, **law):
    """An interface that another one resembles but for a word, or for when its load comes."""
    load = sf.InterfaceLoad(lambda x, t: 0.2 * (abs(x) < 1) * (t > since), history=None)
    return scene_along(UNIT, sf.SlipWeakening(0.6, 0.3, 0.5, **law), 16.0, 1.0, 0.3, loads=[load])


def under_state(evolution):
    law = sf.RateAndState(0.01, 0.014, 0.6, 1e-3, 1e-2, evolution=evolution)
    return scene_along(UNIT, law, 16.0, 1.0, 0.3, rate=1e-3)


def assert_same(left, other):
    for name in FIELDS:
        first, second = getattr(left.interface, name), getattr(other.interface, name)
        assert np.array_equal(first, second, equal_nan=True), name
    for first, second in ((left.totals, other.totals), (left.seen, other.seen)):
        assert all(map(np.array_equal, vars(first).values(), vars(second).values()))
    assert left.work == other.work


@pytest.mark.thinned(2)
@pytest.mark.parametrize("stop_at", [37, 90])
def test_a_run_goes_on_to_the_last_bit(stop_at, tmp_path):
    """Adaptive steps, thinned frames, through a file: as if it had not been interrupted."""
    counted = iter(range(10**6))
    options = {"nodes": 64, "estimate": False, "every": 3, "frames": 20}
    whole = march(weakening_fault(), 12.0, **options)
    stop = {"progress": lambda *_: next(counted) == stop_at - 1}
    part = march(weakening_fault(), 12.0, **options, **stop)
    assert part.status.startswith("interrupted")
    assert part.steps == stop_at < whole.steps
    part.save(tmp_path / "a.h5")
    fault = weakening_fault()
    saved = sf.Marched.load(tmp_path / "a.h5", fault)
    assert_same(march(fault, 12.0, go_on=saved, **options), whole)
    assert len(whole.interface.t) <= 22
    assert np.diff(whole.totals.t).max() > 100 * np.diff(whole.totals.t).min()


@pytest.mark.parametrize(
    ("fault", "end", "stop", "under_way"),
    [
        (
            opening_fault(),
            3.0,
            1.7,
            lambda part, whole: part.interface.gap[-1].max() > 0 == whole.interface.gap[-1].max(),
        ),
        (glued_fault(), 1.0, 0.4, lambda part, whole: part.checkpoint.state.opened.max() > 0.3),
        (two_bodies(), 1.0, 0.5, lambda part, whole: part.interface.slip.max() > 0),
        (forced_front(), 2.0, 0.6, lambda part, whole: part.interface.slip.max() > 0),
        (
            moved_grid(),
            1.5,
            0.7,
            lambda part, whole: part.shift != 0 and part.interface.slip.max() > 0,
        ),
    ],
    ids=["open", "parted", "two bodies", "forced front", "moved grid"],
)
def test_what_a_fault_has_gone_through_is_gone_on_with(fault, end, stop, under_way, tmp_path):
    """Gaps, faces that have parted, coupled pressure and a strength that falls: to the last bit."""
    options = {"nodes": 64, "estimate": False, "every": 2}
    whole = march(fault, end, **options)
    part = march(fault, end, **options, progress=lambda t, _: t > stop)
    assert part.status.startswith("interrupted")
    assert under_way(part, whole)
    part.save(tmp_path / "a.h5")
    part = sf.Marched.load(tmp_path / "a.h5", fault)
    assert_same(march(fault, end, go_on=part, **options), whole)


@pytest.mark.parametrize("until", [2.0, 0.7357, 2.01])
@pytest.mark.parametrize("fault", [jumping(), opening_fault(), weakening_fault(), glued_fault()])
def test_a_run_goes_on_after_an_end_time_to_the_last_bit(fault, until, tmp_path):
    """At a jump, between two steps, and between a jump and the first step after it."""
    options = {"nodes": 128, "estimate": False, "every": 3}
    whole, begun = march(fault, 4.0, **options), march(fault, until, latest=4.0, **options)
    begun.save(tmp_path / "a.h5")
    begun = sf.Marched.load(tmp_path / "a.h5", fault)
    assert begun.end_time == until
    assert_same(march(fault, 4.0, go_on=begun, **options), whole)


@pytest.mark.parametrize(
    ("own", "other"),
    [
        (weakening_fault(), scene_along(UNIT, COULOMB, 16.0, even=True)),
        (opening_fault(), opening_fault(-3.1)),
        (glued_fault(), glued_fault(1.1)),
        (struck(), struck(shape="exponential")),
        (struck(), struck(since=2.0)),
        (under_state("ageing"), under_state("slip")),
        (moved_grid(), moved_grid(-2.04)),  # within a cell
    ],
    ids=["fault", "load", "strength", "shape", "past", "evolution", "contact"],
)
def test_another_interface_is_not_gone_on_with(own, other):
    part = march(own, 1.0, 32, estimate=False, latest=3.0)
    with pytest.raises(sf.SceneError, match="another scene"):
        march(other, 3.0, 32, go_on=part)
    with pytest.raises(sf.SceneError, match="end_time must be above 1"):
        march(own, 0.5, 32, go_on=part)


def test_what_an_earlier_run_has_not_kept_is_not_asked_of_it():
    fault = weakening_fault()
    asked = {"times": [0.005, 0.01], "slipping": 1e-3, "latest": 0.02}
    part = march(fault, 0.01, 32, estimate=False, **asked)
    whole = march(fault, 0.02, 32, estimate=False, go_on=part, times=[0.005, 0.02])
    assert whole.interface.t.tolist() == [0.005, 0.01, 0.02]
    with pytest.raises(sf.SceneError, match=r"gone beyond t = 0\.002 and not stored it"):
        march(fault, 0.02, 32, go_on=part, times=[0.002, 0.02])
    with pytest.raises(sf.SceneError, match="leave out `slipping`"):
        march(fault, 0.02, 32, go_on=part, slipping=1e-2)
    part = march(jumping(), 2.0, 128, latest=4.0, estimate=False)
    with pytest.raises(sf.SceneError, match="can be continued to 4; for more, start again"):
        march(part.scene, 200.0, 128, go_on=part)


def test_what_is_done_is_kept_after_ctrl_c():
    def press(time, end):
        if time > 0.5:
            signal.raise_signal(signal.SIGINT)

    load = sf.InterfaceLoad(lambda x: np.exp(-(x**2)))
    done = march(scene_along(UNIT, COULOMB, 8.0, loads=[load]), 2.0, 64, progress=press)
    assert done.status.startswith("interrupted at t = 0.5")
    assert done.interface.slip[-1].max() > 0
    assert done.interface.t[-1] == done.end_time < 0.6


def test_a_saved_run_is_loaded_with_its_own_interface_alone(tmp_path):
    """Another contact, period or symmetry lies on other nodes."""
    strip = sf.Contact([(-2.0, 2.0)])
    own = scene_along(UNIT, COULOMB, 8.0, contact=strip)
    march(own, 0.2, 32, estimate=False).save(tmp_path / "own.h5")
    assert sf.Marched.load(tmp_path / "own.h5", own).nodes == 32
    assert sf.Marched.load(tmp_path / "own.h5").scene == own
    for other in (
        {"period": 16.0, "contact": strip},
        {"period": 8.0},
        {"period": 8.0, "contact": sf.Contact([(-1.0, 2.0)])},
        {"period": 8.0, "contact": strip, "even": True},
    ):
        with pytest.raises(sf.DataFileError, match="is a march of another scene"):
            sf.Marched.load(tmp_path / "own.h5", scene_along(UNIT, COULOMB, **other))
    by_function = scene_along(UNIT, COULOMB, 8.0, loads=[sf.InterfaceLoad(np.cos)])
    march(by_function, 0.2, 32).save(tmp_path / "own.h5")
    with pytest.raises(sf.DataFileError, match="give the scene as well"):
        sf.Marched.load(tmp_path / "own.h5")
    assert sf.Marched.load(tmp_path / "own.h5", by_function).companion.nodes == 16
    march(moved_grid(), 0.2, 200, estimate=False).save(tmp_path / "own.h5")
    other = replace(moved_grid(), contact=sf.Contact([(-2.04, 1.9)]))
    with pytest.raises(sf.DataFileError, match="is a march of another scene"):
        sf.Marched.load(tmp_path / "own.h5", other)


def test_an_interrupt_during_the_estimate_leaves_the_complete_run():
    sent = []

    def shear(x, t):
        if len(x) == 32 and t > 0.3 and not sent:
            sent.append(t)
            signal.raise_signal(signal.SIGINT)
        return 0.5 * np.exp(-(x**2)) * min(t, 1.0)

    loads = [sf.InterfaceLoad(shear, history=None)]
    fault = scene_along(UNIT, sf.Coulomb(0.3), 16.0, shear=0.1, loads=loads)
    done = march(fault, 1.0, nodes=64, rtol=1e-6)
    assert sent
    assert done.is_interrupted
    assert done.error_estimates == {}
    assert done.end_time == 1.0
    assert np.array_equal(
        done.interface.slip, march(fault, 1.0, nodes=64, estimate=False).interface.slip
    )
