"""Scenes on a line in a few words, as studies and tests state them by the dozen."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import semianalytic as sa


def scene_along(
    material: sa.Material,
    law: sa.Law,
    period: float,
    pressure: Any = 1.0,
    shear: Any = 0.0,
    loads: Any = (),
    contact: sa.Contact | None = None,
    mode: str = "in-plane",
    **more: Any,
) -> sa.Scene:
    """Return a scene on a line of a period [length], whose bodies touch everywhere by default.

    Pressure and shear [stress] are those of the base; others are those of `Scene`.  Loads act on
    the line where they do not say otherwise.
    """
    base = sa.Tractions(pressure, shear)
    touching = sa.Contact() if contact is None else contact
    # where there are slots a scene asks where loads act
    loads = [
        replace(load, on="line") if isinstance(load, sa.InterfaceLoad) and load.on is None else load
        for load in ([loads] if isinstance(loads, sa.InterfaceLoad) else loads)
    ]
    return sa.Scene(material, law, base, loads, period=period, contact=touching, mode=mode, **more)
