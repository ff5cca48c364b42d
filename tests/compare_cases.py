"""Stand-ins for finite-element runs whose answer is known: the prediction itself, sampled."""

from types import SimpleNamespace

import numpy as np

from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.named import NAMED_SCENES

SELF_SIMILAR = [
    name
    for name, named in NAMED_SCENES.items()
    if named.scene.is_self_similar and named.scene.load.pressure >= 0
]


class SampledRun(SimpleNamespace):
    """What compare asks of a simulation; all its nodes lie beyond the edge."""

    opened = None
    caution = ""


def sampled_run(solution, resolution=100, times=40, end_time=1.0, stretch=1.0, gain=1.0):
    """What a simulation without any error would have recorded, or one with a known error.

    `stretch` multiplies all speeds, `gain` all slip rates and tractions.
    """
    scene = solution.scene
    cell = scene.material.shear_speed * end_time / resolution
    reach = 1.06 * scene.material.longitudinal_speed * end_time
    x = cell * (0.01 + np.arange(int(reach / cell) + 1))
    t = end_time * np.arange(1, times + 1) / times
    seen_at = x / stretch, t[:, None]
    velocity_x, velocity_y = solution.slot_velocity(-x / stretch, t[:, None])
    history = InterfaceHistory(
        x=x,
        t=t,
        slip=solution.slip(*seen_at),
        slip_rate=gain * solution.slip_rate(*seen_at),
        shear_traction=gain * solution.shear_traction(*seen_at),
        pressure=gain * solution.pressure(*seen_at),
    )
    return SampledRun(
        scene=scene,
        end_time=end_time,
        resolution=resolution,
        element_size=cell,
        damping=0.0,
        model="sampled",
        run="sampled",
        time_step=t[0],
        critical_step=t[0],
        steps=len(t),
        unknowns=0,
        seconds={},
        interface=history,
        final_path=gain * solution.path(x / stretch, end_time),
        final_work_density=gain**2 * solution.work_density(x / stretch, end_time),
        slot=SimpleNamespace(x=-x, t=t, velocity_x=velocity_x, velocity_y=velocity_y),
    )
