"""Stand-ins for finite-element runs whose answer is known: the exact answer itself, sampled."""

import functools
from dataclasses import replace

import numpy as np

from fem import Simulation, simulate, with_companions
from fem.results import EnergyHistory, SlotHistory
from semianalytic import Tractions
from semianalytic.results.answer import TOTALS
from semianalytic.results.sampled import Totals
from semianalytic.scene.given.named import NAMED_SCENES

SELF_SIMILAR = [
    name
    for name, named in NAMED_SCENES.items()
    if named.scene.is_self_similar
    and isinstance(named.scene.load, Tractions)
    and named.scene.lower_material is None
]
"""Named self-similar scenes of equal bodies that finite elements simulate."""


def _gained(traction, gain):
    """A traction times a factor, but for the first level."""
    return np.concatenate([traction[:1], gain * traction[1:]])


@functools.cache
def sampled_run(
    solution,
    resolution=100,
    times=40,
    end_time=1.0,
    stretch=1.0,
    gain=1.0,
    growth=1.0,
    companions=2,
):
    """What a simulation without any error would have recorded, or one with a known error.

    `stretch` multiplies all speeds, `gain` all slip, slip rates and, from the first step on,
    tractions: those at t = 0 are in place.  What they are off 1 by grows by the factor `growth`
    from each mesh to its companion of twice the element size: 2 is an error of first order, which
    the error bars show; 1 is one that no mesh shows.  Tests change copies: each run is made once.
    """
    scene = solution.scene
    cell = scene.material.shear_speed * end_time / resolution
    reach = 1.06 * scene.fastest_speed * end_time
    x = cell * np.arange(1, int(reach / cell) + 1)
    t = end_time * np.arange(times + 1) / times
    seen = solution.history(x / stretch, t)
    velocity_x, velocity_y = solution.slot_velocity(-x / stretch, t[:, None])
    path = gain * solution.path(x / stretch, end_time)
    work = gain**2 * solution.work_density(x / stretch, end_time)
    coarser = None
    if companions:
        coarser = sampled_run(
            solution,
            resolution // 2,
            times,
            end_time,
            1 + growth * (stretch - 1),
            1 + growth * (gain - 1),
            growth,
            companions - 1,
        )
    return Simulation(
        scene=scene,
        end_time=end_time,
        resolution=resolution,
        element_size=cell,
        damping=0.0,
        mesh="squares",
        model="sampled",
        step_ratio=1.0,
        time_step=float(t[1]),
        critical_step=float(t[1]),
        rate_window=0.0,
        steps=times,
        unknowns=0,
        interface=replace(
            seen,
            x=x,
            slip=gain * seen.slip,
            slip_rate=gain * seen.slip_rate,
            shear_traction=_gained(seen.shear_traction, gain),
            pressure=_gained(seen.pressure, gain),
            gap=gain * seen.gap,
        ),
        state=np.zeros(seen.slip.shape, dtype=np.int8),
        slip_after=np.zeros((0, len(x))),
        final_path=path,
        final_work_density=work,
        totals=Totals(t, *(getattr(solution, name)(t) for name in TOTALS)),
        opened=None,
        slot=SlotHistory(-x[::-1], t, velocity_x[:, ::-1], velocity_y[:, ::-1]),
        energy=EnergyHistory(t, *np.zeros((6, times + 1))),
        seconds={"steps": 0.0},
        run="sampled",
        unwritten="",
        companion=coarser,
    )


@functools.cache
def simulated(scene, resolution, end_time=1.0):
    """A finite-element run with its companions; each is run once for all tests."""
    return with_companions(simulate(scene, end_time, resolution=resolution))


class Spoilt:
    """An answer with some of its methods replaced; no Solution, but asked like one."""

    def __init__(self, answer, **replaced):
        self._answer = answer
        self.__dict__.update(replaced)

    def __getattr__(self, name):
        return getattr(self._answer, name)

    def history(self, x, t):
        from semianalytic.results.answer import sampled_history

        return sampled_history(self, x, t)


def named(judgement):
    return {row.name: row for row in judgement.rows}


def differing(judgement):
    return [row.name for row in judgement.having("differs")]
