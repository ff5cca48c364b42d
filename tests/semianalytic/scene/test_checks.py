"""Numbers of any type are taken, everything else is refused in one sentence; results compare."""

import copy
import pickle
from dataclasses import fields, is_dataclass, replace
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from catalogue import PRELOADED, unit_scene

import fem
import semianalytic as sf
import slipfront
from fem.plan import Plan
from fem.results import EnergyHistory, SlotHistory
from fem.settings import Pace, Settings
from semianalytic.dissimilar_slot.derivative import PairDerivative
from semianalytic.dissimilar_slot.solution import PairSolution
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.checks import LARGEST, SMALLEST, shown
from semianalytic.selfsimilar.derivatives.derivative import Derivative

TAKES_A_NUMBER = {
    "shear_modulus": lambda value: sf.Material(value, 1.0, 0.3),
    "density": lambda value: sf.Material(1.0, value, 0.3),
    "poisson_ratio": lambda value: sf.Material(1.0, 1.0, value),
    "pressure": lambda value: sf.Tractions(value, 0.0),
    "shear": lambda value: sf.Tractions(0.0, value),
    "friction": lambda value: replace(PRELOADED, friction=value),
    "rise_time": sf.Ramp,
    "duration": sf.Pulse,
    "frequency": sf.Harmonic,
    "static": lambda value: sf.RateWeakening(value, 0.1, 1.0),
    "rate": lambda value: sf.RateWeakening(1.0, 0.5, value),
    "distance": lambda value: sf.SlipWeakening(1.0, 0.5, value),
    "times": lambda value: sf.Tabulated((value,), (1.0,)),
    "values": lambda value: sf.Tabulated((1.0,), (value,)),
    "end_time": lambda value: Plan(PRELOADED, value, Settings()),
    "damping": lambda value: Settings(damping=value),
    "step_ratio": lambda value: Settings(step_ratio=value),
    "checkpoint_seconds": lambda value: Pace(seconds=value if value is not None else "None"),
}
TAKES_A_SIZE = ("shear_modulus", "density", "duration", "frequency", "rate", "distance", "end_time")

NO_NUMBERS = [
    True,
    "0.25",
    None,
    0.25 + 0j,
    np.array([[0.25, 0.5]] * 40),
    float("nan"),
    np.float64("inf"),
    10**5000,
    1e300,
]
"""One of each kind: no number, no real one, several, long to show, infinite, out of range."""


def stored(made):
    """All numbers a description holds, tables included."""
    for field in fields(made):
        value = getattr(made, field.name)
        if is_dataclass(value):
            yield from stored(value)
        else:
            yield from value if isinstance(value, tuple) else (value,)


@pytest.mark.thinned(3)
@pytest.mark.parametrize("make", TAKES_A_NUMBER.values(), ids=TAKES_A_NUMBER)
@pytest.mark.parametrize(
    "value",
    [np.float64(0.25), np.float32(0.25), np.float16(0.25), np.array(0.25), Fraction(1, 4)],
    ids=repr,
)
def test_numbers_of_other_types_are_the_same_number(make, value):
    made = make(value)
    assert made == make(0.25)
    kinds = {type(array) for array in stored(made)}
    assert kinds <= {float, int, str, type(None)} | {type(p) for p in stored(make(0.25))}
    assert 0.25 in list(stored(made))


@pytest.mark.parametrize(
    "make",
    [make for name, make in TAKES_A_NUMBER.items() if name not in ("poisson_ratio", "damping")],
)
def test_integers_are_numbers(make):
    assert make(np.int64(1)) == make(np.uint8(1)) == make(1) == make(1.0)


@pytest.mark.thinned(13)
@pytest.mark.parametrize("make", TAKES_A_NUMBER.values(), ids=TAKES_A_NUMBER)
@pytest.mark.parametrize("value", NO_NUMBERS, ids=lambda value: shown(value)[:20])
def test_anything_else_is_refused_in_one_short_sentence(make, value):
    with pytest.raises(sf.SceneError) as caught:
        make(value)
    message = str(caught.value)
    assert "\n" not in message
    assert message.endswith(".")
    assert len(message) < 250


@pytest.mark.parametrize("name", TAKES_A_SIZE)
def test_sizes_whose_products_overflow_are_refused_with_the_range(name):
    make = TAKES_A_NUMBER[name]
    for value in (SMALLEST, LARGEST):
        make(value)
    for value in (SMALLEST / 10, 10 * LARGEST):
        with pytest.raises(sf.SceneError, match=r"1e-60 and 1e\+60"):
            make(value)


def test_tables_refuse_what_is_not_a_number_and_slopes_beyond_range():
    for bad in ("12", [True, 1.0], ["0", 1.0], 3.0, None):
        with pytest.raises(sf.SceneError, match="lists of numbers"):
            sf.Tabulated(bad, (0.0, 1.0))
    with pytest.raises(sf.SceneError, match="give the same time twice"):
        sf.Tabulated((0.0, 1e-300), (0.0, 1.0))
    table = sf.Tabulated(np.array([0, 1]), np.array([0.0, 2.0], dtype=np.float32))
    assert table == sf.Tabulated((0.0, 1.0), (0.0, 2.0))


@pytest.mark.parametrize(
    ("name", "said"),
    [
        *((name, "must be a ") for name in ("material", "base", "load")),
        *((f"{word}_history", "must be one of Step, Ramp") for word in ("pressure", "shear")),
        ("friction", "must be a finite number or a law"),
    ],
)
def test_parts_of_a_scene_of_the_wrong_type_are_named(name, said):
    with pytest.raises(sf.SceneError, match=f"scene: {name} {said}"):
        replace(PRELOADED, **{name: "rock"})


@pytest.mark.parametrize("value", [50.0, True, "50", None, 10**400, 10**17], ids=shown)
def test_counts_are_whole_numbers_of_bounded_size(value):
    given = value if value is not None else "None"  # no number of nodes is the default one
    for take in (
        lambda: sf.solve(PRELOADED, method="space-time", nodes=given),
        lambda: sf.solve(PRELOADED, method="space-time", every=value),
        lambda: Settings(resolution=value),
        lambda: Settings(frames=value),
    ):
        with pytest.raises(sf.SceneError, match=r"whole number|integer|at most"):
            take()


def test_options_of_a_march_are_numbers_of_any_type():
    plain = sf.solve(
        PRELOADED, method="space-time", end_time=0.25, nodes=32, damping=0.5, step_ratio=0.5
    )
    other = sf.solve(
        PRELOADED,
        method="space-time",
        end_time=np.float32(0.25),
        nodes=np.int64(32),
        damping=np.float32(0.5),
        step_ratio=Fraction(1, 2),
    )
    np.testing.assert_array_equal(plain.interface.slip, other.interface.slip)
    for name in ("end_time", "length", "latest", "damping", "step_ratio", "tolerance"):
        for value in ("1", True, 10**400, 1e300, float("nan")):
            with pytest.raises(sf.SceneError, match=f"march: {name} must"):
                sf.solve(PRELOADED, method="space-time", **{"nodes": 32, name: value})


def test_a_sweep_takes_numbers_only():
    swept = sf.sweep(PRELOADED, [np.float32(0.25), Fraction(1, 2)], rtol=1e-4)
    assert swept.friction.tolist() == [0.25, 0.5]
    for bad in (["0.3"], [True], [None], [[1.0], 2.0], [10**400]):
        with pytest.raises(sf.SceneError, match="friction"):
            sf.sweep(PRELOADED, bad)


def test_results_can_be_compared_and_kept_in_sets():
    history = [sf.solve(PRELOADED).history([0.1, 0.2], [1.0]) for _ in range(2)]
    simulations = [fem.simulate(PRELOADED, resolution=8) for _ in range(2)]
    marches = [sf.solve(PRELOADED, method="space-time", nodes=16) for _ in range(2)]
    solutions = [sf.solve(PRELOADED) for _ in range(2)]
    sweeps = [sf.sweep(PRELOADED, [0.3], rtol=1e-3) for _ in range(2)]
    for answer, other in (history, simulations, marches, solutions, sweeps):
        assert answer == answer
        assert answer != other
        assert len({answer, other}) == 2
        assert [answer, other].index(other) == 1


@pytest.mark.parametrize("package", [sf, fem])
def test_no_public_result_compares_arrays_with_each_other(package):
    public = [getattr(package, name) for name in package.__all__]
    public += [
        Derivative,
        EnergyHistory,
        InterfaceHistory,
        PairDerivative,
        PairSolution,
        SlotHistory,
    ]
    results = [kind for kind in public if isinstance(kind, type) and is_dataclass(kind)]
    with_arrays = [
        kind
        for kind in results
        if any("Array" in str(field.type) or "Profile" in str(field.type) for field in fields(kind))
    ]
    assert InterfaceHistory in with_arrays
    for kind in with_arrays:
        assert kind.__eq__ is object.__eq__, kind


# --- what is no scene at all ----------------------------------------------------------------------

TIMES = np.array([0.1, 0.2])
GAUGE = sf.Gauge(0.4, TIMES, TIMES, 0.1)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (
            lambda: slipfront.solve(0.3, method="space-time"),
            "space-time is for a Scene, or the name or file of one, got 0.3",
        ),
        (lambda: slipfront.solve(None), "or the name or file of one, got None."),
        (lambda: slipfront.simulate("none.toml"), "none.toml cannot be read"),
        (lambda: slipfront.cost(3), "simulate: scene must be a Scene, or the name or file"),
        (lambda: slipfront.sweep("", [0.1]), "There is no scene called ''"),
        (lambda: slipfront.survey((), friction=[0.1]), "survey: scene must be a Scene"),
        (lambda: slipfront.validate({}, 1.0), "validate: scene must be a Scene"),
        (lambda: slipfront.find(3), "find: give a name or the path of a TOML file, got 3."),
        (lambda: slipfront.fit([GAUGE], b"a", "friction"), "fit: scene must be a Scene"),
        (lambda: slipfront.fit(7, PRELOADED, "friction"), "fit: gauges must be a sequence"),
        (lambda: slipfront.fit([GAUGE], PRELOADED, "friction", priors=3), "priors must be a"),
        (
            lambda: slipfront.fit([GAUGE], PRELOADED, "friction", setup=3),
            "fit: setup must be a Setup",
        ),
        (
            lambda: slipfront.read_gauges(["a.csv"], noise=5e-8),
            "read_gauges: noise must be a mapping",
        ),
        (lambda: slipfront.read_gauges(["a.csv"], noise={"slp": 1.0}), "read_gauges: noise takes"),
        (lambda: slipfront.read_gauges(7), "read_gauges: paths must be a path or several, got 7"),
        (lambda: slipfront.find("a\0b.toml"), "cannot be read (embedded null byte)"),
        (
            lambda: slipfront.survey(PRELOADED, client="x", friction=[0.1]),
            "client must be one of dask.distributed, got 'x'.",
        ),
        (lambda: slipfront.survey(PRELOADED, together=3, friction=[0.1]), "must be True or False"),
        (lambda: slipfront.solve(PRELOADED).animate("a.gif", []), "animate: t must be one or more"),
        (lambda: slipfront.simulate(PRELOADED, resume=[1, 2]), "resume must be True or False"),
        (
            lambda: slipfront.solve("ramp", nodes=16, estimate=None),
            "estimate must be True or False",
        ),
        (lambda: unit_scene(lower_material="steel"), "scene: lower_material must be a Material"),
        (lambda: unit_scene(step=3), "no parameter 'step'; it has material, friction, base, load"),
    ],
)
def test_what_is_no_scene_or_parameter_ends_in_one_sentence(call, said):
    with pytest.raises(sf.SceneError) as refusal:
        call()
    message = str(refusal.value)
    assert said in message
    assert message.endswith((".", "?"))


def test_scenes_are_copied_and_changed_as_before():
    """Though parameters that are none are refused before they are."""
    for same in (copy.deepcopy(PRELOADED), pickle.loads(pickle.dumps(PRELOADED))):
        assert same == PRELOADED
    assert replace(PRELOADED, friction=0.4).friction == 0.4


# --- methods of scenes and answers ----------------------------------------------------------------

NODES = np.full(4, 0.4)
SOLVED = sf.solve(PRELOADED)
BLOCK = {"material": PRELOADED.material, "height": 1.0, "left": -1.0, "right": 1.0}
FILM = {"material": PRELOADED.material, "strength_ratio": 0.3, "viscosity": 0.5}
LAWS = [
    sf.Coulomb(0.3),
    sf.SlipWeakening(0.5, 0.3, 0.1),
    sf.RateWeakening(0.5, 0.3, 0.1),
    sf.RateAndState(0.01, 0.02, 0.6, 1e-6, 1e-3),
]
METHODS = [
    *[
        (law.strength, {"pressure": NODES, "speed": NODES, "state": NODES}, "pressure")
        for law in LAWS
    ],
    *[(law.on, {"x": NODES}, "x") for law in LAWS],
    (sf.Ramp(0.5).value, {"t": NODES}, "t"),
    (sf.Pulse(0.5).mean, {"start": NODES, "end": 1.0 + NODES}, "start"),
    (sf.Contact(((-1.0, 1.0),)).touches, {"x": NODES}, "x"),
    (sf.Contact(((-1.0, 1.0),)).ends, {"length": 8.0}, "length"),
    (sf.IncidentWave("P", 10.0, 1.0).tractions, {"material": PRELOADED.material}, "material"),
    (sf.Tractions(1.0, 0.0).plus, {"other": sf.Tractions(1.0, 0.0)}, "other"),
    (sf.Normal(1.0, 0.1).misfit, {"value": 0.3}, "value"),
    (sf.Setup().gain_of, {"gauge": sf.Gauge(0.4, NODES.cumsum(), NODES, 0.1)}, "gauge"),
    (SOLVED.derivative("friction").slip, {"x": NODES, "t": 1.0}, "x"),
    (SOLVED.slip, {"x": NODES, "t": 1.0}, "t"),
    (fem.Block, BLOCK, "preload"),
    (fem.Block, BLOCK, "far_side"),
    (slipfront.reference.viscous_edge_speed, FILM, "mode"),
    (slipfront.reference.viscous_edge_speed, FILM, "viscosity"),
    (slipfront.reference.viscous_edge_speed, FILM, "strength_ratio"),
    (sf.InterfaceLoad(1.0).acts, {"name": "shear"}, "name"),
    (sf.InterfaceLoad(1.0).traction, {"x": NODES, "t": 1.0}, "of"),
    (sf.Contact(((-1.0, 1.0),)).misfit, {"length": 8.0, "nodes": 8}, "nodes"),
    (sf.Contact(((-1.0, 1.0),)).shortened, {"length": 8.0, "nodes": 8}, "length"),
    (sf.Contact, {}, "intervals"),
    (SOLVED.arrival, {"x": NODES}, "of"),
    (fem.cost, {"scene": PRELOADED}, "snapshots"),
    (fem.cost, {"scene": PRELOADED}, "memory"),
]


class Failing:
    """A table of another package that has a shape, but of which numpy can make no array."""

    shape = (4,)

    def __array__(self, *options, **more):
        raise RuntimeError("no array of this")


@pytest.mark.thinned(5)
@pytest.mark.parametrize(("method", "right", "name"), METHODS)
@pytest.mark.parametrize(
    "wrong",
    [
        *([[1.0], [1.0, 2.0]], "word", set(), b"ab", 10**400, Failing(), 1j * NODES),
        *(np.ma.masked_less(NODES, 1.0), np.array(["2020-01-01"], dtype="M8[D]"), Decimal(1)),
    ],
    ids=lambda wrong: type(wrong).__name__,
)
def test_methods_name_the_argument_of_a_wrong_type(method, right, name, wrong):
    with pytest.raises(sf.SceneError, match=rf"\b{name}\b.* got .*\.$"):
        method(**right | {name: wrong})


@pytest.mark.parametrize("law", LAWS)
def test_methods_of_laws_take_lists_and_return_nan_without_a_warning(law):
    known = law.strength(NODES, NODES, NODES)
    for row in (NODES.tolist(), NODES.astype(object), [Fraction(2, 5)] * 4):
        np.testing.assert_array_equal(law.strength(row, NODES, row), known)
    assert law.strength(-1, np.float32(0.5), 1) == law.strength(-1.0, 0.5, 1.0)
    for wrong in (np.nan, -0.5, 0.0, np.inf):
        for name in ("pressure", "speed", "state"):
            found = law.strength(**{"pressure": NODES, "speed": NODES, "state": NODES, name: wrong})
            assert np.shape(found) == NODES.shape
    assert not law.weakening([])


def test_limits_of_closed_forms_are_said_where_no_root_exists():
    with pytest.raises(sf.SceneError, match=r"poisson_ratio above -0\.42"):
        sf.regimes.log_narrow_reverse_threshold(-0.5)
    for ratio in (1e-20, 1e30):
        with pytest.raises(sf.SceneError, match="strength_ratio must"):
            slipfront.reference.viscous_edge_speed(**FILM | {"strength_ratio": ratio})
    for nu in (-0.3, -0.6):  # where the shear front slips first, the contact is at rest
        viscous, dry = (sf.regimes.nucleation("remote", nu, film) for film in (0.5, 0.0))
        assert viscous == pytest.approx(dry, rel=1e-4)


def test_positions_and_times_that_do_not_fit_are_refused_with_their_shapes():
    with pytest.raises(sf.SceneError, match=r"slip: shapes must fit .* x \(2,\), t \(1, 3\)\.$"):
        SOLVED.slip([0.1, 0.2], [[0.5, 1.0, 1.5]])


def test_a_method_that_fails_by_itself_is_not_blamed_on_its_arguments():
    class Broken(sf.LoadHistory):
        pieces = None

        def turn(self, width: float, until: float) -> float:
            raise ValueError("its own fault")

    with pytest.raises(ValueError, match="its own fault"):
        Broken().turn(0.1, 1.0)
