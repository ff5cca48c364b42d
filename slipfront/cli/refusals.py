"""Translation of refusals into the words of the command line: arguments become options."""

from __future__ import annotations

import re
from collections.abc import Collection

from slipfront.cli.options import option_name

ALIKE = {"nodes": "resolution"}
"""Options that replace arguments a command does not have: the nodes of a march follow from them."""

_SUBJECT = re.compile(r"^(?:\w+(?: \w+)?: )?(\w+(?: \w+)?)(?= must )")
_NAMED = re.compile(r"`(\w+)`")


def in_options(sentence: str, options: Collection[str]) -> str:
    """Return a sentence in which the arguments it names are replaced by options.

    Parameters
    ----------
    sentence : str
        Names arguments `in backticks`, or as its subject: "march: nodes must be ...".
    options : names of arguments
        Arguments that are options of the command; others stay as they are.
    """

    def replaced(match: re.Match[str]) -> str:
        name = match[1].replace(" ", "_")
        name = name if name in options else ALIKE.get(name, name)
        return option_name(name) if name in options else match[0]

    return _NAMED.sub(replaced, _SUBJECT.sub(replaced, sentence))
