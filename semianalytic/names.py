"""Public names of packages: each is listed once, in the stub of its package.

Type checkers read the stub as it is; a name is imported from its module when it is first used.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

_HOUSE = Path(__file__).resolve().parents[1]


@cache
def places(package: str) -> dict[str, tuple[str, str]]:
    """Return the public names of a package, each with its module and its name there.

    They are what its stub imports, or its ``__init__.py`` where it has no stub; the package itself
    is not imported.  The name in the module is empty where the module itself is meant.
    """
    face = _HOUSE.joinpath(*package.split("."), "__init__.py")
    stub = face.with_suffix(".pyi")
    found: dict[str, tuple[str, str]] = {}
    for line in ast.parse((stub if stub.exists() else face).read_text(encoding="utf-8")).body:
        if isinstance(line, ast.ImportFrom) and line.module:
            if line.module == package:  # a module of its own
                found |= {name.name: (f"{package}.{name.name}", "") for name in line.names}
            elif line.names[0].name == "*":
                found |= places(line.module)
            else:
                found |= {name.name: (line.module, name.name) for name in line.names}
    return found


def attached(package: str) -> tuple[list[str], Callable[[str], Any]]:
    """Return ``__all__`` and ``__getattr__`` of a package whose stub lists its public names."""
    known = places(package)

    def get(name: str) -> Any:
        if name not in known:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        place, inner = known[name]
        module = import_module(place)
        value = getattr(module, inner) if inner else module
        setattr(sys.modules[package], name, value)
        return value

    return sorted(known), get
