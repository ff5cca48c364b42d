"""Who may import whom: the witness stays independent, the product stays light."""

import ast
import json
import sys
from collections import Counter
from functools import cache
from pathlib import Path

import packages
import pytest

import slipfront
from slipfront.cli.commands import COMMANDS

ROOT = Path(__file__).parent.parent
DESCRIPTION = ("semianalytic.scene", "semianalytic.results", "semianalytic.names")
"""What a scene and a result are, how they are checked, written and named: no numerics at all."""

ARROWS = {
    "semianalytic": {
        "scene": "",
        "results": "scene",
        "halfplane": "scene",
        "cut": "scene halfplane",
        "separation": "scene halfplane cut",
        "field": "scene halfplane cut dissimilar",
        "selfsimilar": "scene results halfplane cut separation field parameters",
        "memory": "scene",
        "parameters": "scene",
        "engine": "scene results halfplane field memory dissimilar",
        "dissimilar": "scene halfplane",
        "dissimilar_slot": "scene results halfplane field selfsimilar dissimilar parameters",
        "whole_line": "scene results halfplane selfsimilar",
        "reference": "scene halfplane memory dissimilar",
        "sweeps": "scene results halfplane cut selfsimilar",
        "regimes": "scene halfplane cut selfsimilar",
        "inversion": "scene results halfplane cut field selfsimilar sweeps engine parameters",
    },
    "compare": {
        "output": "",
        "records": "",
        "tasks": "",
        "comparison": "output",
        "figures": "comparison output",
        "validation": "records comparison figures output",
        "benchmarks": "records comparison validation output",
        "chart": "comparison figures output tasks",
    },
    "slipfront": {"surveys": "", "fits": "", "explore": "", "cli": "surveys fits explore hidden"},
}
"""What each folder of a package may import of the others of that package, at any depth."""
PACKAGES = {
    "semianalytic": "",
    "meshes": "semianalytic",
    "fem": "semianalytic meshes",
    "compare": "semianalytic meshes fem",
    "slipfront": "semianalytic meshes fem compare",
}
"""What each package may import of the others; docs/studies and docs/examples may import all."""
WITHOUT_NESTED_CIRCLES = ("semianalytic", "meshes", "fem")
"""Packages in which no folder imports from its parent what the parent imports from it.

In the two others a folder of rows, studies or commands uses the tables and options of its parent,
which assembles what the folder holds.
"""


def imported_modules(path):
    return imports_of(path.read_text())


@cache
def parsed(text):
    """Return the tree of a source, which is parsed once for all tests."""
    return ast.parse(text)


@cache
def statements_of(text):
    """Return all statements of a source; of its nodes, most of which are of expressions, a tenth.

    No expression holds a statement, so that all imports are among them.
    """
    found, blocks = [], [parsed(text)]
    for block in blocks:  # which grows meanwhile
        for name in ("body", "orelse", "finalbody", "handlers", "cases"):
            inner = getattr(block, name, ())
            if isinstance(inner, list):  # that of a conditional expression is none
                blocks += inner
                found += inner
    return tuple(found)


@cache
def imports_of(text):
    """Return the modules that a source imports; several tests ask for those of the same files."""
    names = []
    for node in statements_of(text):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names.append(node.module)
    return tuple(names)


def sources(package, root=ROOT):
    """All modules of a package, those of its folders included."""
    return sorted((root / package).rglob("*.py"))


def undue_imports(package):
    """What a package that is to stay independent imports though it must not."""
    for path in sources(package):
        for name in imported_modules(path):
            known = name.startswith(DESCRIPTION) or not name.startswith("semianalytic")
            if not known or name.startswith(("compare", "slipfront")):
                yield path.name, name


@pytest.mark.parametrize("package", ["fem", "meshes"])
def test_witness_sees_only_the_description_of_a_scene(package):
    assert list(undue_imports(package)) == []


def against_the_arrows(package):
    """(file, import) of what a folder takes from another that it should not know."""
    for folder, known in ARROWS[package].items():
        allowed = {folder, *known.split()}
        for path in sources(f"{package}/{folder}"):
            for name in imported_modules(path):
                first, *rest = name.split(".")
                if first == package and (not rest or rest[0] not in allowed):
                    yield str(path.relative_to(ROOT)), name


@pytest.mark.thinned(2)
@pytest.mark.parametrize("package", ARROWS)
def test_arrows_between_folders_run_one_way(package):
    folders = {path.parent.name for path in (ROOT / package).glob("*/__init__.py")}
    assert folders == set(ARROWS[package])
    assert list(against_the_arrows(package)) == []


@pytest.mark.parametrize("package", PACKAGES)
def test_arrows_between_packages_run_one_way(package):
    others = {*PACKAGES, "docs"} - {package, *PACKAGES[package].split()}
    for path in sources(package):
        taken = {name.split(".")[0] for name in imported_modules(path)}
        assert not taken & others, path


def module_name(path, root=ROOT):
    """Return the dotted name of a file; that of a package's face is the package's own."""
    parts = path.relative_to(root).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports_between_files(package, root=ROOT):
    """Return the modules of its package that each module takes from, for type checking too."""
    modules = {module_name(path, root): path for path in sources(package, root)}
    graph = {}
    for name, path in modules.items():
        taken = set()
        for node in statements_of(path.read_text()):
            if isinstance(node, ast.Import):
                taken |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                # A name after `import` may itself be a module of the package.
                inner = {f"{node.module}.{alias.name}" for alias in node.names}
                taken |= inner & modules.keys() or {node.module}
        graph[name] = (taken & modules.keys()) - {name}
    return graph


SPLIT = {f"semianalytic.scene.{word}": "semianalytic.scene" for word in ("laws", "line", "tables")}
"""Folders that hold a part of the trade of their parent, too many files for one folder: scenes hold
laws and fields, which take checks, units and tables from beside the scene."""


def imports_between_folders(package, root=ROOT):
    """Return the folders, nested ones on their own, that the files of each folder take from."""
    files = imports_between_files(package, root)
    faces = {module_name(path, root) for path in (root / package).rglob("__init__.py")}
    folder = {name: name if name in faces else name.rpartition(".")[0] for name in files}
    folder = {name: SPLIT.get(entry, entry) for name, entry in folder.items()}
    graph = {}
    for name, taken in files.items():
        # The face of a folder shows what is inside, in deeper folders too.
        if name not in faces:
            graph.setdefault(folder[name], set()).update(folder[entry] for entry in taken)
    return {name: taken - {name} for name, taken in graph.items()}


def circle_in(graph):
    """Return the nodes that remain when those without an arrow out of them are removed in turn."""
    left = set(graph)
    while ends := {name for name in left if not graph[name] & left}:
        left -= ends
    return sorted(left)


@pytest.mark.parametrize("package", PACKAGES)
def test_no_circle_of_imports_between_files(package):
    assert circle_in(imports_between_files(package)) == []


@pytest.mark.parametrize("package", WITHOUT_NESTED_CIRCLES)
def test_no_circle_of_imports_between_nested_folders(package):
    assert circle_in(imports_between_folders(package)) == []


def test_circles_are_found_between_files_and_between_a_folder_and_its_parent(tmp_path):
    inner = tmp_path / "semianalytic" / "scene" / "given"
    inner.mkdir(parents=True)
    for folder in (inner, inner.parent, inner.parent.parent):
        (folder / "__init__.py").write_text("")
    (inner / "units.py").write_text("from semianalytic.scene.checks import shown\n")
    (inner.parent / "checks.py").write_text("")
    (inner.parent / "law.py").write_text("from semianalytic.scene.given import units\n")
    assert circle_in(imports_between_files("semianalytic", tmp_path)) == []
    nested = ["semianalytic.scene", "semianalytic.scene.given"]
    assert circle_in(imports_between_folders("semianalytic", tmp_path)) == nested
    typed = "if TYPE_CHECKING:\n    from semianalytic.scene.law import Law\n"
    (inner.parent / "checks.py").write_text(typed)
    assert "semianalytic.scene.law" in circle_in(imports_between_files("semianalytic", tmp_path))


MOST = 15
"""Largest number of files of one trade in a folder; its face is none of them."""


def crowded(root):
    """Yield the folders that hold too many files; tests count apart from their helpers."""
    folders = {path.parent for path in root.rglob("*.py")}
    for folder in sorted(folders):
        names = {path.name for path in folder.glob("*.py")} - {"__init__.py"}
        tests = {name for name in names if name.startswith("test_")}
        if max(len(tests), len(names - tests)) > MOST:
            yield folder


@pytest.mark.parametrize("package", PACKAGES)
def test_folders_say_what_they_are_for_and_stay_small(package):
    for face in (ROOT / package).rglob("__init__.py"):
        assert ast.get_docstring(ast.parse(face.read_text())), face
    assert list(crowded(ROOT / package)) == []


@pytest.mark.parametrize("folder", ["tests", "docs"])
def test_folders_of_tests_and_studies_stay_small(folder):
    assert list(crowded(ROOT / folder)) == []


SHOWN = {"scene.py", "sampled.py"}
"""Where the base is checked, shown, or what there is before t = 0."""
SLOT_ALONE = {"dissimilar", "dissimilar_slot", "whole_line"}
"""Folders whose contact carries nothing but the base, and a load that they know themselves."""
ALONG_LINE = {
    *(
        "acting.py",
        "beside_edges.py",
        "bodies.py",
        "estimate.py",
        "line.py",
        "result.py",
        "steps.py",
    ),
    *("case.py", "comparing.py", "along.py", "on_line.py", "documents.py", "data.py"),
    *("quoted.py", "specimen.py"),
}
"""Files of scenes on a line, whose loads act beside the base."""


def of_the_base(node):
    """Whether it asks for a traction of something that is called base."""
    inner = getattr(node, "value", None)
    traction = isinstance(node, ast.Attribute) and node.attr in ("pressure", "shear")
    return traction and isinstance(inner, ast.Attribute) and inner.attr == "base"


def test_what_is_in_place_after_the_load_is_asked_of_the_superposition():
    """The base of a scene is what was there before; the contact carries a remote load as well."""
    asked = {
        path.name
        for package in PACKAGES
        for path in sources(package)
        if not SLOT_ALONE & {*path.relative_to(ROOT).parts}
        if ".base" in (text := path.read_text())  # few are worth a walk through all nodes
        if any(map(of_the_base, ast.walk(parsed(text))))
    }
    assert asked - ALONG_LINE == SHOWN


USES = """
import json, sys, semianalytic
loaded = [list(sys.modules)]
import slipfront
solution = slipfront.solve(slipfront.find("preloaded"))
solution.zones
{use}
loaded.append(list(sys.modules))
print(json.dumps(loaded))
"""


@cache
def loaded_with(use):
    """The modules that a new process has loaded: with `import semianalytic`, and at its end."""
    run = packages.run("", "-c", USES.format(use=use))
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)


def test_each_name_stands_for_one_thing():
    """No class name stands twice, and a user meets at most 70 names and 15 commands."""
    classes = Counter(
        node.name
        for package in PACKAGES
        for path in sources(package)
        for node in ast.walk(parsed(path.read_text()))
        if isinstance(node, ast.ClassDef)
    )
    assert [name for name, count in classes.items() if count > 1] == []
    assert len({*slipfront.__all__} - {"__version__"}) <= 70
    assert len(COMMANDS) <= 15


def test_product_needs_numpy_and_scipy_only():
    allowed = {"numpy", "scipy", "semianalytic", "h5py", "xarray", "pint", "matplotlib"} | set(
        sys.stdlib_module_names
    )
    for path in sources("semianalytic"):
        assert {name.split(".")[0] for name in imported_modules(path)} <= allowed, path
    heavy = {"h5py", "xarray", "pint", "matplotlib", "skfem", "gmsh", "meshio", "rich"}
    assert not heavy & set(loaded_with("")[0])


_DERIVATIVES = (
    "cut.node_fields",
    "cut.rates",
    "selfsimilar.derivatives.derivative",
    "selfsimilar.derivatives.parameters",
    "selfsimilar.derivatives.variation",
    "selfsimilar.derivatives.varied",
)
LATER = (
    "dissimilar",
    "dissimilar_slot",
    "engine",
    "interface",
    "inversion",
    "memory",
    "reference",
    "regimes",
    *_DERIVATIVES,
    "sweeps",
    "whole_line",
)
"""What a plain solution does without."""


@pytest.mark.thinned(6)
@pytest.mark.parametrize(
    ("use", "loaded"),
    [
        ("", ()),
        ("solution.slip_rate(0.3, 1.0)", ()),
        ("solution.derivative('friction')", _DERIVATIVES),
        ("slipfront.fit", ("inversion", *_DERIVATIVES)),
        ("slipfront.sweep", ("sweeps",)),
    ],
)
def test_what_a_plain_solution_does_without_is_loaded_when_it_is_used(use, loaded):
    modules = loaded_with(use)[-1]
    assert [package for package in LATER if f"semianalytic.{package}" in modules] == list(loaded)


def test_zones_are_found_without_scipy():
    """`scipy.special` alone would take half of the time of the first solution in a process."""
    assert [name for name in loaded_with("")[-1] if name.split(".")[0] == "scipy"] == []
