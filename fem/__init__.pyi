# The public names of this package and where they are defined; `semianalytic.names` reads this list.

from fem.budget import cost as cost
from fem.companions import with_companions as with_companions
from fem.lines.plates import find_specimen as find_specimen
from fem.lines.specimen import Block as Block
from fem.lines.specimen import Specimen as Specimen
from fem.results import Simulation as Simulation
from fem.run import simulate as simulate
from fem.settings import Settings as Settings
