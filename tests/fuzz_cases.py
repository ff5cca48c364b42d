"""Random scene files and command lines, most of them wrong in some way; a seed makes each."""

from __future__ import annotations

import random
from dataclasses import dataclass
from pathlib import Path

from catalogue import PRELOADED

from semianalytic.parameters.numbers import numbers_of

MATERIAL = {
    "shear_modulus": ["1.0", "80e9", "1", "2", "1e-60", "1e60"],
    "density": ["1.0", "7800", "1", "3", "1e-60", "1e60"],
    "poisson_ratio": ["0.3", "0.25", "0", "-0.5", "0.45", "-0.999", "0.4999999"],
}
TRACTIONS = {
    "base": {
        "pressure": ["1.0", "1", "2", "5", "1e6", "0", "1e-300", "1e60"],
        "shear": ["0", "0", "0.0", "0.01", "-0.2"],
    },
    "load": {
        "pressure": ["0", "0", "0.0", "0.5", "1", "-0.5"],
        "shear": ["1.0", "-1", "0.7", "0", "1e-9", "1e60"],
    },
}
FRICTION = ["0.3", "1", "0", "5", "1e3", "1e60", "0.01"]
HISTORIES = [
    'kind = "ramp"\nrise_time = 0.5',
    'kind = "ramp"\nrise_time = 0',
    'kind = "pulse"\nduration = 0.4\nshape = "half-sine"',
    'kind = "pulse"\nduration = 1e-60',
    'kind = "harmonic"\nfrequency = 1.5',
    'kind = "tabulated"\nt = [0, 0.5, 0.5, 1]\nvalue_at_t = [0, 1, 0.5, 0]',
    'kind = "tabulated"\nt = [1e60]\nvalue_at_t = [-1e60]',
    'kind = "step"',
    'kind = "step"\nrise_time = 1',
    'kind = "sawtooth"',
    'kind = "tabulated"\nt = [true, 1]\nvalue_at_t = ["0", 1]',
    'kind = "tabulated"\nt = [0, 1e-300]\nvalue_at_t = [0, 1]',
    'kind = ["ramp"]',
    "rise_time = 1",
    "",
]
LAWS = [
    'kind = "coulomb"',
    'kind = "rate-weakening"\nreduction = 0.5\nrate = 10',
    'kind = "rate-weakening"\nreduction = 1\nrate = 1e-60',
    'kind = "slip-weakening"\nreduction = 0.5\ndistance = 1',
    'kind = "slip-weakening"\nreduction = 0.5\ndistance = 1e-9',
    'kind = "slip-weakening"\nreduction = 2\ndistance = 1',
    'kind = "aging"',
]
PLACES = ['"remote"', '"remote"', '"slot"', '"far"', "1", '["remote"]']
STRANGE = ['"x"', "'0.3'", '""', '"ß→漢字"', '"""two\nlines"""', "true", "[]", "[1, 2]"]
STRANGE += ["[[1], [2]]", "{}", "{a = 1}", "1979-05-27", "1979-05-27T07:32:00Z", "07:32:00"]
STRANGE += ["inf", "-inf", "nan", "1e400", "-1e400", "1e300", "1e-320", "-1", "-0.0", "1" * 400]
STRANGE += ["-" + "9" * 400, "1" * 5000, "0xff", "0b1", "1_000", "1__0", "+0.3", ".3", "0.3.3"]
STRANGE += ["", "=", "[" * 3000, "[" * 300 + "]" * 300, "{a=" * 1500]
KEYS = ["zzz", '"two\\nlines"', '"\\u001b[31m"', "ß", '"ß"', "friction", "material.extra", "''"]
NAMES = ["preloaded", "stuck", "remote-shock", "auxetic", "ramp", "pulse", "harmonic", "lift-off"]
NO_NAMES = ["preloadd", "", " ", "ß", "\x1b[31m", "a\nb", "x" * 300, "/", "..", "-", "~", "%s{}"]
NUMBERS = ["0.3", "0", "1", "0.05", "0.45", "2", "20", "-1", "1e-9", "1e60", "0.7"]
WRONG_NUMBERS = ["1e61", "1e300", "1e-300", "nan", "inf", "-inf", "abc", "", "0,3", "1e", "0x1"]
WRONG_NUMBERS += ["ß", "--", " ", "1" * 400, "1" * 5000, "True", "None"]
COUNTS = ["16", "0", "-3", "1.5", "1e3", "abc", "", "1" * 400, "1" * 5000, "٣", "10000000000000000"]

SCENE_OPTIONS = [name.replace("_", "-") for name in (*numbers_of(PRELOADED), "mode")]
WRONG_COMMANDS = [
    [],
    ["solve", "--", "--json"],
    ["scenes", "preloaded"],
    ["field"],
    ["field", "nowhere"],
    ["field", "preloaded", "--gauge", "ß,"],
    ["field", "preloaded", "--animate", "2.5"],
    ["chart", "nowhere"],
    ["solve", "ramp", "--nodes", "16", "--save", "", "--quiet"],
]

REFUSED = [
    ["solve", "ramp", "--nodes", "1000000000000"],
    ["solve", "ramp", "--length", "1e-6"],
    ["solve", "ramp", "--latest", "1e9"],
    ["solve", "ramp", "--step-ratio", "1e-12"],
    ["simulate", "stuck", "--resolution", "8", "--step-ratio", "1e-12"],
    ["simulate", "stuck", "--resolution", "8", "--damping", "1e12"],
    ["chart", "preloaded", "--quiet", "--output", "taken"],
    ["simulate", "stuck", "--resolution", "8", "--quiet", "--no-snapshots", "--output", "taken"],
    ["solve", "ramp", "--nodes", "16", "--quiet", "--save", "taken/march.h5"],
    ["field", "preloaded", "--quiet", "--output", "taken"],
    ["field", "preloaded", "--points", "1000000000"],
]
"""Beyond any machine, or nowhere to write, a file `taken` being there: to be refused at once."""


@dataclass(frozen=True)
class Case:
    """A command line, and what the file it may name holds (None: no such file)."""

    arguments: tuple[str, ...]
    file: bytes | None = None


def random_case(seed: int) -> Case:
    """The case of a seed; the file is called scene.toml."""
    rng = random.Random(seed)
    kind = rng.choices(("file", "options", "commands"), (6, 4, 1))[0]
    if kind == "commands":
        return Case(tuple(rng.choice(WRONG_COMMANDS)))
    content = random_file(rng) if kind == "file" else None
    source = "scene.toml" if kind == "file" else rng.choice(NAMES * 8 + NO_NAMES)
    command = rng.choices(("solve", "simulate", "compare"), (24, 8, 1))[0]
    arguments = [command, source]
    if command == "solve":
        arguments += rng.choice([[], [], ["--json"], ["--method", "space-time"]])
        histories = b"history]" in (content or b"") or source in ("ramp", "pulse", "harmonic")
        marched = histories or b"_law]" in (content or b"") or "space-time" in arguments
        if rng.random() < (1.0 if marched else 0.1):
            arguments += ["--quiet", "--nodes", "16"]
    else:
        arguments += ["--resolution", "8", "--quiet"]
        arguments += [] if rng.random() < 0.1 else ["--no-snapshots"]
    if kind == "options":
        for _ in range(rng.choice([0, 1, 1, 1, 2, 3])):
            arguments += random_option(rng, command)
    return Case(tuple(arguments), content)


def random_option(rng: random.Random, command: str) -> list[str]:
    """An option, right or wrong, but none that would take long."""
    number = rng.choice(rng.choice([NUMBERS, WRONG_NUMBERS]))
    common = [["--" + rng.choice(SCENE_OPTIONS), number]] * 4
    common += [[f"--{rng.choice(SCENE_OPTIONS)}={number}"], ["--frction", "1"], ["--friction"]]
    common += [["--method", rng.choice(["auto", "fem", "", "self-similar"])], ["-x"], ["extra"]]
    path = rng.choice(["out", "taken", "taken/below", "", "x" * 300, "a\nb", "new/folder/ß"])
    own = {
        "solve": [
            ["--json"],
            ["--plot", path],
            ["--plot", rng.choice(["a.png", "taken/a.png", "a.docx", ".png", "new/a.pdf"])],
            ["--nodes", rng.choice(COUNTS)],
            ["--end-time", number],
            ["--step-ratio", rng.choice(["0", "3", "-1", "nan", "x"])],
            ["--save", path],
            ["--save", "march.h5"],
            ["--go-on", rng.choice(["absent.h5", "taken", "broken.h5", "."])],
        ],
        "simulate": [
            ["--output", path],
            ["--resolution", rng.choice([*COUNTS, "7", "1000000"])],
            ["--frames", rng.choice(COUNTS)],
            ["--end-time", number],
            ["--mesh", rng.choice(["squares", "triangles", "cubes", ""])],
            ["--model", rng.choice(["auto", "two-blocks", "one"])],
            ["--step-ratio", rng.choice(["0", "3", "1.4", "nan", "x"])],
            ["--damping", rng.choice(["0", "-1", "nan", "x", "0.5"])],
            ["--resume"],
            ["--checkpoint-every", rng.choice(COUNTS)],
            ["--checkpoint-seconds", number],
        ],
    }
    own["compare"] = [*own["simulate"][:9], ["--from", rng.choice(["absent", "taken", ".", ""])]]
    return rng.choice([*common, *own[command]])


def random_file(rng: random.Random) -> bytes:
    """A scene file with up to three faults, or something else altogether."""
    if rng.random() < 0.08:
        return rng.choice(
            [
                b"",
                b"\n\n# nothing\n",
                b"\x00",
                b"\xff\xfe\x00f",
                b"\x89HDF\r\n\x1a\n",
                rng.randbytes(200),
                b"friction = 1",
                "# ß\n".encode("latin-1"),
                b"[" * 5000,
                b"a." * 3000 + b"a = 1",
            ]
        )
    lines = [f"friction = {rng.choice(FRICTION)}", "[material]"]
    lines += [f"{key} = {rng.choice(values)}" for key, values in MATERIAL.items()]
    for table, keys in TRACTIONS.items():
        lines.append(f"[{table}]")
        lines += [f"{key} = {rng.choice(values)}" for key, values in keys.items()]
    for name, parts in (
        ("pressure_history", HISTORIES),
        ("shear_history", HISTORIES),
        ("friction_law", LAWS),
    ):
        if rng.random() < 0.2:
            lines += [f"[{name}]", *rng.choice(parts).split("\n")]
    if rng.random() < 0.2:
        lines.insert(0, f"load_on = {rng.choice(PLACES)}")
    for _ in range(rng.choice([0, 0, 0, 0, 1, 1, 2, 3])):
        _break(lines, rng)
    text = ("\ufeff" if rng.random() < 0.02 else "") + "\n".join(lines)
    return text.encode()[: len(text) // 2 if rng.random() < 0.02 else None]


def _break(lines: list[str], rng: random.Random) -> None:
    """One fault in a scene file."""
    where = rng.randrange(len(lines))
    fault = rng.choice(["value", "value", "value", "drop", "double", "key", "insert", "noise"])
    key = lines[where].partition(" = ")[0]
    if fault == "value":
        lines[where] = f"{key} = {rng.choice(STRANGE)}"
    elif fault == "drop" and len(lines) > 1:
        del lines[where]
    elif fault == "double":
        lines.insert(where, lines[where])
    elif fault == "key":
        lines[where] = f"{rng.choice(KEYS)} = 1"
    elif fault == "insert":
        lines.insert(
            where, rng.choice(["[zzz]", "[[material]]", "zzz = 1", "]", "friction_law = 1"])
        )
    else:
        at = rng.randrange(len(lines[where]) + 1)
        noise = rng.choice(['"', "[", "\x07", "\u2028", "#", "é", "'"])
        lines[where] = lines[where][:at] + noise + lines[where][at:]


def prepare(folder: Path, case: Case) -> None:
    """What a case finds in its folder: a taken name, broken files, perhaps its scene file."""
    (folder / "taken").write_text("")
    (folder / "broken.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(100))
    if case.file is not None:
        (folder / "scene.toml").write_bytes(case.file)
