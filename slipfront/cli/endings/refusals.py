"""Refusals in the words of the command line, in one sentence: arguments become options.

typer and click word theirs each in its own way, and print them in a box of several lines.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import typer

from semianalytic import Scene
from semianalytic.scene.errors import ComputationError, SceneError
from slipfront.cli.options import option_name

ALIKE = {"nodes": "resolution"}
"""Options that replace arguments a command does not have: the nodes of a march follow from them."""
_SUBJECT = re.compile(r"^(?:\w+(?: \w+)?: )?(\w+(?: \w+)?)(?= must | has a unit)")
_NAMED = re.compile(r"`(\w+)`")
_REFUSAL: Any = typer.BadParameter.__base__  # UsageError, of click or of the copy in newer typers
_NUMBER = re.compile(r"\bvalid (integer|float|number)")
"""Messages of all versions about text that is no number."""


def in_options(sentence: str, options: Collection[str]) -> str:
    """Return a sentence in which the arguments it names are replaced by options of the command.

    It names arguments `in backticks`, or as its subject: "march: nodes must be ...".
    """

    def replaced(match: re.Match[str]) -> str:
        name = match[1].replace(" ", "_")
        name = name if name in options else ALIKE.get(name, name)
        return option_name(name) if name in options else match[0]

    return _NAMED.sub(replaced, _SUBJECT.sub(replaced, sentence))


def check_converged(solution: Any, label: str) -> None:
    """Raise ComputationError unless a solution has converged; call after printing."""
    if solution.status != "converged":
        raise ComputationError(
            f"{label} has not converged: {solution.status}; do not rely on this answer, "
            "change friction a little or simulate the scene."
        )


def check_no_march_options(given: Mapping[str, Any], problem: Scene) -> None:
    """Raise SceneError if an exact solution is asked for with options of marches."""
    if given:
        marched = problem.kind == "Scene"
        remedy = "add --method space-time" if marched else "leave it out"
        raise SceneError(
            f"{option_name(next(iter(given)))} is for the space-time solver; {remedy}."
        )


def refuse_given(options: Mapping[str, Any], reason: str) -> None:
    """Raise SceneError for the first option that was given."""
    for name, value in options.items():
        if value is not None:
            raise SceneError(f"{option_name(name)} {reason}.")


def specimen_settings(settings: Mapping[str, Any], others: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings of a simulation of a specimen; raise SceneError for other options."""
    known = ("end_time", "size", "damping", "step_ratio")
    others = {**{name: n for name, n in settings.items() if name not in known}, **others}
    refuse_given(others, "is for scenes; a specimen takes --size, or a change of its file")
    return {name: settings[name] for name in known if settings.get(name) is not None}


def without_effect(*two: str) -> SceneError:
    """Refusal of two options that exclude one another."""
    option, other = map(option_name, two)
    return SceneError(f"{option} has no effect with {other}; leave one of the two out.")


@contextmanager
def in_one_sentence() -> Iterator[None]:
    """Raise what click would report in a box, such as an unknown option, as a SceneError.

    Its sentence has the option or the argument in question as subject.
    """
    try:
        yield
    except _REFUSAL as error:
        if type(error).__name__ == "NoArgsIsHelpError":  # which shows the help
            raise
        raise SceneError(sentence(error)) from None


def sentence(error: Any) -> str:
    """Return a refusal by click or typer as one sentence that names the option as it is typed."""
    called = getattr(error.ctx, "command_path", "slipfront")
    param: Any = getattr(error, "param", None)
    name = "" if param is None else _typed(param)
    if hasattr(error, "possibilities"):
        if str(error.option_name).startswith("--lower-"):
            return (
                f"{called} has no option {error.option_name}, for it takes identical bodies only; "
                "slipfront solve, compare, explore, field, survey and simulate take others "
                "(docs/dissimilar.md)."
            )
        guesses = " or ".join(sorted(error.possibilities or ()))
        more = f"did you mean {guesses}?" if guesses else f"'{called} --help' lists them."
        if error.option_name == "--material":
            more = "slipfront init mine.toml --material writes a scene of a listed solid."
        return f"{called} has no option {error.option_name}; {more}"
    if name and type(error).__name__ == "MissingParameter":
        return f"{name} is missing; '{called} --help' describes it."
    message = " ".join((error.message or error.format_message()).split())
    if not name:
        asks = message.endswith("?")
        return message if asks else f"{message.rstrip('.')}; see '{called} --help'."
    if message.startswith("must "):
        return f"{name} {message}"
    number = _NUMBER.search(message)
    if number is None:
        return f"{name}: {message}"
    return f"{name} must be a {'whole ' if number[1] == 'integer' else ''}number."


def _typed(param: Any) -> str:
    """Return a parameter as it is typed or shown in the help: --end-time, SCENE."""
    if param.param_type_name == "option":
        return str(max(param.opts, key=len))
    return str(param.metavar or param.name.upper()).strip("{}.")
