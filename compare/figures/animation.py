"""Animations of fields as GIF or MP4."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from subprocess import CalledProcessError

from matplotlib.animation import FFMpegWriter, PillowWriter

from compare.figures.fields import FieldPicture
from semianalytic.results.files import new_file
from semianalytic.results.plotting import write_frames
from semianalytic.scene.errors import ComputationError, MissingLibraryError

PER_SECOND = 15
"""Frames per second of an animation."""
WRITERS: Mapping[str, type[PillowWriter | FFMpegWriter]] = {
    "gif": PillowWriter,
    "mp4": FFMpegWriter,
}


def check_format(form: str) -> None:
    """Raise MissingLibraryError unless animations in a format of `WRITERS` can be written."""
    if not WRITERS[form].isAvailable():
        raise MissingLibraryError(
            f"An animation as {form} needs the program ffmpeg, which is not installed; install it "
            "(apt install ffmpeg), or take the format gif."
        )


def write_animation(
    path: Path,
    picture: FieldPicture,
    times: Sequence[float],
    progress: Callable[[int, int], object] | None = None,
) -> None:
    """Write a picture at several times [time] as an animation, in the format of its file name.

    The suffix is a key of `WRITERS`; the file appears only when it is complete, and `progress` is
    called with (frame, frames) after each.  A DataFileError says that it cannot be written, a
    ComputationError that ffmpeg fails.
    """
    with new_file(path, suffix=path.suffix) as part:
        writer = WRITERS[path.suffix[1:]](fps=PER_SECOND)
        try:
            write_frames(part, picture.figure, picture.show, times, writer, progress)
        except (CalledProcessError, BrokenPipeError) as error:
            raise ComputationError(
                f"ffmpeg could not write {path}; check that it works, or take the format gif."
            ) from error
