"""Files of a user that Python imports in place of a package of slipfront."""

from importlib.util import find_spec
from pathlib import Path


def hiding() -> str:
    """Say in a sentence which file of the user is imported in place of a package of ours, or "".

    Python looks in the folder of a script first, so that a ``fem.py`` next to it becomes `fem`.
    """
    house = Path(__file__).parents[1]
    for name in ("semianalytic", "fem", "meshes", "compare"):
        spec = find_spec(name)
        if spec is None or spec.origin is None or Path(spec.origin).parent != house / name:
            found = spec and (spec.origin or spec.name)
            return f"{found} hides the package {name!r} of slipfront; rename or move it."
    return ""
