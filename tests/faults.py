"""Disks that are full, rights that are missing, and one of every kind of file that is read back."""

import os
import random
import subprocess
import sys
import tempfile
from contextlib import contextmanager, suppress
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from fault_tasks import history

from compare.chart.points import COMMAND, read_points
from compare.comparison.fields.frames import last_frame
from compare.output.tables import write_rows
from fem import simulate
from fem.checkpoint import Checkpoint, read_checkpoint, write_checkpoint
from fem.results import load_simulation
from meshes import Blocks, mesh_of
from meshes.build import cache_path
from semianalytic import Marched, find, solve
from semianalytic.results.files import Seal, new_file, write_bytes
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.given.named import NAMED_SCENES

ROOT = Path(__file__).parent.parent
ROOM = 8192
"""What a full disk has left, or how long a file may get [bytes]; less than any kind needs."""

NOBODY = 65534
BLOCKS = Blocks(size=0.1, left=20, right=20, height=10, pattern="triangles")


@dataclass(frozen=True)
class Kind:
    """A kind of file: how one is written into a folder, and what is read back from it."""

    path: Any
    write: Any
    read: Any


def identity_of(thing):
    """All that a thing holds, to be compared to the last bit."""
    if isinstance(thing, np.ndarray):
        return (thing.shape, thing.dtype.str, thing.tobytes())
    if isinstance(thing, float):
        return np.float64(thing).tobytes()
    if is_dataclass(thing) and not isinstance(thing, type):
        return tuple((f.name, identity_of(getattr(thing, f.name))) for f in fields(thing))
    if isinstance(thing, dict):
        return tuple((key, identity_of(value)) for key, value in sorted(thing.items()))
    if isinstance(thing, (list, tuple)):
        return tuple(map(identity_of, thing))
    return repr(thing)


def write_frame(folder):
    """A snapshot of two blocks and its index."""
    x, y = np.meshgrid(np.arange(-20.0, 21.0), np.arange(0.0, 11.0))
    upper = np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()])
    quads = np.array([[i, i + 1, i + 42, i + 41] for i in range(410) if i % 41 != 40])
    random = np.random.default_rng(2)
    moved, cells = (2 * len(upper), 3), 2 * len(quads)
    frame = meshio.Mesh(
        np.concatenate([upper, upper * [1, -1, 1]]),
        [("quad", np.concatenate([quads, quads + len(upper)]))],
        point_data={name: random.normal(size=moved) for name in ("velocity", "displacement")},
        cell_data={f"sigma_{name}": [random.normal(size=cells)] for name in ("xx", "yy", "xy")},
    )
    with new_file(folder / "last.vtu", seal=Seal.XML) as part:
        meshio.write(part, frame, file_format="vtu")
    write_index(folder)


def write_index(folder):
    text = '<VTKFile><Collection><DataSet timestep="1.5" file="last.vtu"/></Collection></VTKFile>'
    write_bytes(folder / "fields.pvd", text.encode(), Seal.XML)


def read_mesh_again(path):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SLIPFRONT_CACHE", str(path.parent))
        mesh = mesh_of(BLOCKS)
    return (mesh.p, mesh.t)


def save_history(folder):
    history().save(folder / "history.h5")


def all_kinds():
    """Every kind of file that is read back, by name; computes a small march and simulation."""
    marched = solve(NAMED_SCENES["ramp"].scene, method="space-time", end_time=0.3, nodes=40)
    fault = find("cattaneo")
    run = solve(fault, end_time=0.05, nodes=128, estimate=False)
    simulation = simulate(NAMED_SCENES["preloaded"].scene, resolution=16)
    points = read_points(ROOT / "docs" / "data" / "chart.csv")
    parts = {"body 0": {"displacement": np.random.default_rng(3).normal(size=4000)}}
    checkpoint = Checkpoint(7, parts, [(0.5, "fields-0001.vtu")])
    who = {"scene": "some"}
    return {
        "history": Kind("history.h5", save_history, InterfaceHistory.load),
        "march": Kind("march.h5", lambda folder: marched.save(folder / "march.h5"), Marched.load),
        "run": Kind(
            "run.h5",
            lambda folder: run.save(folder / "run.h5"),
            lambda path: Marched.load(path, fault),
        ),
        "simulation": Kind(
            "simulation.h5", simulation.save, lambda path: load_simulation(path.parent)
        ),
        "checkpoint": Kind(
            "checkpoint.h5",
            lambda folder: write_checkpoint(folder / "checkpoint.h5", who, checkpoint),
            lambda path: read_checkpoint(path, who),
        ),
        "mesh": Kind(
            cache_path(BLOCKS).name, lambda folder: read_mesh_again(folder / "any"), read_mesh_again
        ),
        "snapshot": Kind("last.vtu", write_frame, lambda path: last_frame(path.parent)),
        "index": Kind("fields.pvd", write_frame, lambda path: last_frame(path.parent)),
        "chart": Kind(
            "chart.csv",
            lambda folder: write_rows(folder / "chart.csv", points, checked=True, command=COMMAND),
            read_points,
        ),
    }


def flip_bits(data, number, rng):
    """The data with some bits of it, at random places, turned over."""
    damaged = bytearray(data)
    for place in rng.sample(range(8 * len(damaged)), number):
        damaged[place // 8] ^= 1 << place % 8
    return bytes(damaged)


def randomness(seed):
    return random.Random(seed)


@contextmanager
def small_disk(size):
    """A file system of its own, of that many bytes; for root."""
    folder = Path(tempfile.mkdtemp())
    options = ["-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)]
    subprocess.run(["mount", *options], check=True, capture_output=True)
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)
        folder.rmdir()


def can_mount():
    if not sys.platform.startswith("linux") or os.geteuid() != 0:
        return False
    with suppress(OSError, subprocess.CalledProcessError), small_disk(65536):
        return True
    return False


@contextmanager
def full_disk(how, folder):
    """A folder in which a file can still be opened and not much be written.

    Either a file system that is full ("disk"), or a limit on the length of files ("limit").
    """
    if how == "disk":
        with small_disk(1 << 20) as place:
            (place / "filler").write_bytes(bytes((1 << 20) - ROOM))
            yield place, (place / "filler").unlink
        return
    import resource  # which Windows lacks

    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)

    def lift():
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))

    resource.setrlimit(resource.RLIMIT_FSIZE, (ROOM, hard))
    try:
        yield folder, lift
    finally:
        lift()


FULL = ("limit", "disk") if can_mount() else ("limit",) if sys.platform != "win32" else ()


@contextmanager
def open_folder():
    """A folder that anyone can reach."""
    folder = Path(tempfile.mkdtemp())
    folder.chmod(0o755)
    try:
        yield folder
    finally:
        subprocess.run(["rm", "-rf", str(folder)], check=True)


@contextmanager
def as_nobody():
    """Without the rights of root; an ordinary user stays who he is."""
    root = os.geteuid() == 0
    if root:
        os.seteuid(NOBODY)
    try:
        yield
    finally:
        if root:
            os.seteuid(0)


def start(code, *arguments, **options):
    """A Python process that runs some code in the folder of the project."""
    return subprocess.Popen(
        [sys.executable, "-c", code, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=options.pop("cwd", ROOT),
        start_new_session=True,
        **options,
    )
