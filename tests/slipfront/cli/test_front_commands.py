"""Waves at an angle and moving loads on the command line: marched, and refused in one sentence."""

from dataclasses import replace

import pytest

from semianalytic import find_scene, solve

PULSE = """
friction = 0.4
material = {shear_modulus = 1.0, density = 1.0, poisson_ratio = 0.25}
base = {pressure = 1.0, shear = 0.1}
load = {kind = "incident-wave", wave = "SV", angle = -20.0, stress = 0.4}
pressure_history = {kind = "pulse", duration = 0.5}
shear_history = {kind = "pulse", duration = 0.5}
"""


@pytest.mark.slow
def test_a_pulse_at_an_angle_in_a_file_is_marched(printed, tmp_path):
    path = tmp_path / "pulse.toml"
    path.write_text(PULSE)
    document = printed(f"solve {path} --nodes 100")
    assert document["method"] == "space-time"
    assert document["scene"]["load"]["angle"] == -20.0
    assert document["reach_of_reverse_slip"] > 0.03
    assert printed(f"solve {path} --nodes 100 --friction 5")["largest_slip"] == 0


def test_a_march_knows_the_intensity_of_the_moving_front(printed):
    stuck = printed("solve incident-sv --friction 5 --method space-time --nodes 40")
    marched = stuck["stress_intensity_of_a_stuck_edge"]
    exact = solve(replace(find_scene("incident-sv"), friction=5.0)).stress_intensity(1.0)
    assert list(marched.values()) == pytest.approx([float(one) for one in exact], rel=1e-12)


def test_sv_beyond_critical_is_marched_if_asked_for(printed):
    wave = "solve incident-sv --angle 45 --wave-stress=-0.3 --nodes 40 --friction 0.1"
    near, far = (printed(f"{wave} --method space-time --entry {entry}") for entry in (0.5, 1.0))
    assert near["stress_intensity_of_a_stuck_edge"] == {}
    assert near["statistics"]["steps"] < far["statistics"]["steps"]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("solve incident-sv --angle 45", "or march it from where it enters the slot"),
        ("solve incident-sv --angle 45", "--method space-time"),
        ("solve incident-sv --angle 95", "--angle must lie between -89.9 and 89.9 degrees"),
        ("solve incident-sv --wave P --wave-stress=-3", "leave the contact pressed together"),
        ("solve moving-load --load-speed 0", "finite number other than 0"),
        ("solve moving-load --load-speed 1e-9", "slower than 0.0001 of the shear wave"),
        ("solve moving-load --load-speed 1e300", "leave the range of floating point"),
        ("solve incident-sv --angle=-10 --wave-stress 2", "exceeds friction"),
        (
            "solve incident-sv --angle=-10 --wave-stress 2 --method space-time",
            "the wave alone exceeds friction",
        ),
        ("solve incident-sv --method space-time --entry 1", "comes along the slot"),
        ("solve incident-p --method space-time --nodes 40", "would turn tensile"),
    ],
)
def test_bad_input_ends_in_one_sentence_and_exit_code_2(refused, words, sentence):
    assert sentence in refused(words)
