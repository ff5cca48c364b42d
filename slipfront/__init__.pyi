# The public names of slipfront and where they are defined; `semianalytic.names` reads this list.

from compare.comparison.comparing import compare as compare
from compare.validation import *
from fem import *
from semianalytic import *
from slipfront.fits import *
from slipfront.loading import load as load
from slipfront.surveys import *

__version__: str
