"""``python -m slipfront``: the command line, where no program of that name is on the path."""

import sys

from slipfront.cli.entry import main

sys.exit(main())
