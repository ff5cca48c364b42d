"""The command ``slipfront`` with its subcommands, and the exit code of each ending."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from importlib import import_module
from inspect import getdoc
from io import TextIOWrapper
from typing import Annotated, Any

import typer
from rich.markup import escape
from typer.core import TyperGroup

from semianalytic.scene.checks import checked_word
from semianalytic.scene.errors import ComputationError, DataFileError, SceneError, SlipfrontError
from semianalytic.scene.extras import needing
from semianalytic.scene.plugins import plugin_at_fault
from slipfront.cli.endings.faults import INTERRUPTED, INTERRUPTION, READER_GONE, crashed, printable
from slipfront.cli.endings.refusals import in_one_sentence, in_options
from slipfront.cli.endings.unread import unread_said

NO_MEMORY = "There is not enough memory for this; ask for less at once, or on a larger machine."


class _Commands(TyperGroup):
    """Group of commands that reports unexpected endings, which typer would pass over, as faults.

    Exit code 1 remains reserved for answers that differ.  Words that no command knows are refused
    in one sentence, as all other input is.
    """

    def make_context(self, *args: Any, **given: Any) -> Any:
        """Read the options before the command."""
        with in_one_sentence():
            return super().make_context(*args, **given)

    def invoke(self, ctx: Any) -> Any:
        """Run a command; a file that ends too early and a library that exits count as faults."""
        try:
            with in_one_sentence():
                return super().invoke(ctx)
        except EOFError as error:
            raise RuntimeError("a file ends before it should") from error
        except SystemExit as end:
            if isinstance(end.__context__, BrokenPipeError):  # `main` handles this one
                raise
            raise RuntimeError(f"a library ended the program with {end.code!r}") from end


def _show_version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        print(f"slipfront {version('slipfront')}")
        raise typer.Exit


_LEVELS = ("debug", "info", "warning")


class _ToTerminal(logging.Handler):
    """Prints messages to the error output of the moment."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print a message with the name of its module and the time since the start."""
        where, seconds = record.name, record.relativeCreated / 1e3
        print(printable(f"{seconds:8.2f} s  {where}: {record.getMessage()}"), file=sys.stderr)


def slipfront(
    context: typer.Context,
    log: Annotated[
        str | None,
        typer.Option(
            metavar="LEVEL",
            help="Print messages of this level and above: debug, info or warning.",
        ),
    ] = None,
    version: Annotated[
        bool,
        typer.Option(
            "--version",
            callback=_show_version,
            is_eager=True,
            help="Show the version and exit.",
        ),
    ] = False,
) -> None:
    """Where, when, how fast and which way a frictional interface slips after a sudden load."""
    if log is None:
        return
    checked_word("--log", log, _LEVELS)
    handler = _ToTerminal()
    for name in ("slipfront", "semianalytic", "fem", "meshes", "compare"):
        logger = logging.getLogger(name)
        before = logger.level
        logger.setLevel(log.upper())
        logger.addHandler(handler)
        context.call_on_close(partial(logger.setLevel, before))
        context.call_on_close(partial(logger.removeHandler, handler))


_GROUPS: Mapping[str, Mapping[str, tuple[str, str]]] = {
    "Solve and look": {
        "solve": ("solve_command", "solve_command"),
        "field": ("field_command", "field_command"),
        "explore": ("explore_command", "explore_command"),
        "sliding": ("scenes.sliding", "sliding"),
    },
    "Simulate and compare": {
        "compare": ("compare_command", "compare_command"),
        "simulate": ("simulate_command", "simulate_command"),
        "chart": ("chart_command", "chart"),
    },
    "Data": {
        "validate": ("measured.validate_command", "validate_command"),
        "fit": ("measured.fit_command", "fit_command"),
        "benchmark": ("measured.benchmark_command", "app"),
    },
    "Many scenes": {
        "survey": ("survey_command", "survey_command"),
        "scenes": ("scenes.commands", "scenes"),
        "init": ("scenes.commands", "init"),
    },
    "Documentation": {"docs": ("docs_command", "docs")},
}
"""Commands in the order of the help, with the module of this package and the name in it."""
COMMANDS = {name: at for group in _GROUPS.values() for name, at in group.items()}


def command_for(arguments: Sequence[str]) -> Any:
    """Return the command line with the command that the arguments call, else with all of them.

    Modules of other commands are not imported, nor are their options read: both together take
    longer than a solution.  All are needed for the help, and to say which word was meant.  Where a
    shell asks for completions, the arguments are those of the line that is being typed.
    """
    words = list(arguments) or _typed()
    if words[:1] == ["--log"]:
        words = words[2:]
    elif words and words[0].startswith("--log="):
        words = words[1:]
    return _group(words[0] if words and words[0] in COMMANDS else "")


def _help_of(command: Callable[..., Any]) -> str:
    """Return the docstring of a command with a line for each paragraph, which terminals fold."""
    paragraphs = (getdoc(command) or "").split("\n\n")
    # names of tables, such as [material], are no markup
    return escape("\n\n".join(" ".join(words.split()) for words in paragraphs))


def _typed() -> list[str]:
    """Return the words before the one that a shell asks to complete; none if no shell asks."""
    asked = os.environ.get("_SLIPFRONT_COMPLETE", "")
    if not asked.startswith("complete_"):
        return []
    if asked == "complete_bash":
        count = int(os.environ.get("COMP_CWORD", "0"))
        return os.environ.get("COMP_WORDS", "").split()[1:count]
    line = os.environ.get("_TYPER_COMPLETE_ARGS", "")
    return line.split()[1:] if line.endswith(" ") else line.split()[1:-1]


@cache  # a refusal looks its options up in it again
def _group(called: str) -> Any:
    """Return the group with one command, or with all of them where none is called."""
    app = typer.Typer(cls=_Commands, no_args_is_help=True, pretty_exceptions_enable=False)
    app.callback()(slipfront)
    for name in [called] if called else COMMANDS:
        module, attribute = COMMANDS[name]
        command = getattr(import_module(f"slipfront.cli.{module}"), attribute)
        panel = next(title for title, group in _GROUPS.items() if name in group)
        if isinstance(command, typer.Typer):
            app.add_typer(command, name=name, rich_help_panel=panel)
        else:
            app.command(name, help=_help_of(command), rich_help_panel=panel)(command)
    return typer.main.get_command(app)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line, on the words of this process unless given, and return its exit code.

    It is 0 on success, 1 if two answers differ by more than their error bars allow, 2 for a usage
    or scene error, 3 for a damaged file, 4 for a failed computation, 5 for a missing or broken
    package, 70 for a fault of the program, 130 when interrupted (the program itself returns 143 if
    that was by SIGTERM), 141 if the reader of the output is gone.
    """
    arguments = sys.argv[1:] if arguments is None else arguments
    for stream in (sys.stdout, sys.stderr):  # replace what a terminal cannot show, do not fail
        if isinstance(stream, TextIOWrapper) and stream.errors == "strict":
            stream.reconfigure(errors="replace")
    os.environ["MPLBACKEND"] = "agg"  # figures go to files, so that no other backend needs to exist
    try:
        with needing("This command"), unread_said(as_json="--json" in arguments):
            if any("\0" in word for word in arguments):  # no system gives it, callers in Python may
                raise SceneError("The command contains a NUL character; leave it out.")
            command_for(arguments)(args=arguments, prog_name="slipfront")
    except SlipfrontError as error:
        print(printable(in_options(str(error), _options(arguments))), file=sys.stderr)
        return error.exit_code
    except OSError as error:
        reason = f"Cannot use {error.filename or 'a file'}: {error.strerror or error}."
        print(printable(reason), file=sys.stderr)
        return DataFileError.exit_code
    except MemoryError:
        print(NO_MEMORY, file=sys.stderr)
        return ComputationError.exit_code
    except SystemExit as end:
        if isinstance(end.__context__, BrokenPipeError):
            return READER_GONE
        if end.code == INTERRUPTED:
            print(INTERRUPTION, file=sys.stderr)
        return int(end.code or 0)
    except Exception as error:
        foreign = plugin_at_fault(error)
        if foreign is None:
            return crashed(error, arguments)
        print(printable(foreign), file=sys.stderr)
        return foreign.exit_code
    return 0


def _options(arguments: Sequence[str]) -> set[str]:
    """Return the names of the options of the called command and of its subcommands."""
    command = command_for(arguments)
    options: set[str] = set()
    for word in arguments:
        commands = getattr(command, "commands", {})
        if word in commands:  # words before it, such as --log info, are options of all commands
            command = commands[word]
            options |= {each.name for each in command.params if each.param_type_name == "option"}
    return options
