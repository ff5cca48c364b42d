"""Packages of a user's own, put where Python finds them as installed."""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parent.parent


def documented_package():
    """The pyproject.toml and the modules of docs/extending.md, by name."""
    page = (ROOT / "docs" / "extending.md").read_text()
    blocks = re.findall(r"```\w+\n# ([\w.]+)\n(.*?)```", page, re.DOTALL)
    files = {name: text for name, text in blocks if name != "slider.toml"}
    return files.pop("pyproject.toml"), files


def install(folder, pyproject, files):
    """Put a package into a folder as pip would: its modules, and metadata with its entry points."""
    project = tomllib.loads(pyproject)["project"]
    for name, text in files.items():
        (folder / name).write_text(text)
    metadata = folder / f"{project['name']}-{project['version']}.dist-info"
    metadata.mkdir(parents=True)
    (metadata / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
    )
    lines = []
    for group, entries in project["entry-points"].items():
        lines += [f"[{group}]", *(f"{name} = {value}" for name, value in entries.items())]
    (metadata / "entry_points.txt").write_text("\n".join(lines) + "\n")


def brought(name, module, **groups):
    """A pyproject.toml that brings things of one module: group=["name = attribute", ...]."""
    lines = [f'[project]\nname = "{name}"\nversion = "1"']
    for group, entries in groups.items():
        lines.append(f'[project.entry-points."slipfront.{group}"]')
        pairs = (entry.split(" = ") for entry in entries)
        lines += [f'"{key}" = "{module}:{attribute}"' for key, attribute in pairs]
    return "\n".join(lines)


def run(folder, *arguments, cwd=None, **variables):
    """The command line, or ``-c`` code, in a process that finds the packages of a folder."""
    start = [] if arguments[0] == "-c" else ["-m", "slipfront"]
    return subprocess.run(
        [sys.executable, *start, *arguments],
        capture_output=True,
        text=True,
        check=False,
        cwd=cwd,
        env=os.environ | {"PYTHONPATH": str(folder)} | variables,
    )
