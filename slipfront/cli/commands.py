"""The command ``slipfront`` with its subcommands, and the exit code of each ending."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Sequence
from functools import partial
from importlib.metadata import version
from io import TextIOWrapper
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from semianalytic.scene.checks import shown
from semianalytic.scene.errors import ComputationError, DataFileError, SceneError, SlipfrontError
from semianalytic.scene.extras import needing
from slipfront.cli.compare_command import compare_command
from slipfront.cli.endings.faults import READER_GONE, crashed, printable
from slipfront.cli.endings.interruption import INTERRUPTED, INTERRUPTION
from slipfront.cli.endings.refusals import in_one_sentence, in_options
from slipfront.cli.explore_command import explore_command
from slipfront.cli.field_command import field_command
from slipfront.cli.measured.benchmark_command import app as benchmark_app
from slipfront.cli.measured.fit_command import fit_command
from slipfront.cli.measured.validate_command import validate_command
from slipfront.cli.run_command import run_command
from slipfront.cli.scenes.commands import init, scenes
from slipfront.cli.scenes.sliding import sliding
from slipfront.cli.simulate_command import simulate_command
from slipfront.cli.solve_command import solve_command
from slipfront.cli.studies import study_commands as studies
from slipfront.cli.studies.survey_command import survey_command

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


app = typer.Typer(cls=_Commands, no_args_is_help=True, pretty_exceptions_enable=False)


def _show_version(asked: bool) -> None:
    if asked:
        print(f"slipfront {version('slipfront')}")
        raise typer.Exit


_LEVELS = ("debug", "info", "warning")


class _ToTerminal(logging.Handler):
    """Prints messages to the error output of the moment."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print a message with the name of its module and the time since the start."""
        where, seconds = record.name, record.relativeCreated / 1e3
        print(printable(f"{seconds:8.2f} s  {where}: {record.getMessage()}"), file=sys.stderr)


def _show_messages(context: typer.Context, level: str | None) -> None:
    """Print what the packages log at a level and above, until the command has ended."""
    if level is None:
        return
    if level not in _LEVELS:
        raise SceneError(f"--log must be one of {', '.join(_LEVELS)}, got {shown(level)}.")
    handler = _ToTerminal()
    for name in ("slipfront", "semianalytic", "fem", "meshes", "compare"):
        logger = logging.getLogger(name)
        before = logger.level
        logger.setLevel(level.upper())
        logger.addHandler(handler)
        context.call_on_close(partial(logger.setLevel, before))
        context.call_on_close(partial(logger.removeHandler, handler))


@app.callback()
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
    _show_messages(context, log)


app.command("compare")(compare_command)
app.command("solve")(solve_command)
app.command("run")(run_command)
app.command("simulate")(simulate_command)
app.command("field")(field_command)
app.command("explore")(explore_command)
app.add_typer(benchmark_app, name="benchmark")
app.command("validate")(validate_command)
app.command("fit")(fit_command)
app.command("survey")(survey_command)


for command in (
    scenes,
    init,
    sliding,
    studies.regimes,
    studies.stability,
    studies.article,
    studies.chart,
    studies.wear,
    studies.evidence,
):
    app.command()(command)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        Words after ``slipfront``; those of this process by default.

    Returns
    -------
    int
        0 on success, 1 if two answers differ by more than their error bars allow, 2 for a usage
        or scene error, 3 for a damaged file, 4 for a failed computation, 5 for a missing or
        broken package, 70 for a fault of the program, 130 when interrupted (the program itself
        returns 143 if that was by SIGTERM), 141 if the reader of the output is gone.
    """
    arguments = sys.argv[1:] if arguments is None else arguments
    _make_streams_lenient()
    os.environ["MPLBACKEND"] = "agg"  # figures go to files, so that no other backend needs to exist
    try:
        with needing("This command"):
            app(args=arguments, prog_name="slipfront")
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
        return crashed(error, arguments)
    return 0


def _options(arguments: Sequence[str]) -> set[str]:
    """Return the names of the options of the called command and of its subcommands."""
    command: Any = typer.main.get_command(app)
    options: set[str] = set()
    for word in arguments:
        commands = getattr(command, "commands", {})
        if word not in commands:
            break
        command = commands[word]
        options |= {one.name for one in command.params if one.param_type_name == "option"}
    return options


def _make_streams_lenient() -> None:
    """Make output streams replace characters that a terminal cannot show instead of failing."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper) and stream.errors == "strict":
            stream.reconfigure(errors="replace")
