"""Refusals in the words of the command line: arguments of functions become its options."""

from __future__ import annotations

import re
from collections.abc import Collection

from compare.cli.options import option_name

ALIKE = {"nodes": "resolution"}
"""What stands for an argument where a command does not have it: nodes of a march follow from it."""

_SUBJECT = re.compile(r"^(?:\w+(?: \w+)?: )?(\w+(?: \w+)?)(?= must )")
_NAMED = re.compile(r"`(\w+)`")


def in_options(sentence: str, options: Collection[str]) -> str:
    """A sentence with the arguments it names as options.

    Parameters
    ----------
    sentence : str
        Arguments are `in backticks`, or are what must be something: "march: nodes must be ...".
    options : names of arguments
        That are options of the command; others stay as they are.
    """

    def replaced(match: re.Match[str]) -> str:
        name = match[1].replace(" ", "_")
        name = name if name in options else ALIKE.get(name, name)
        return option_name(name) if name in options else match[0]

    return _NAMED.sub(replaced, _SUBJECT.sub(replaced, sentence))
