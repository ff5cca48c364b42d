# The public names of this package and where they are defined; `semianalytic.names` reads this list.

from fem.budget import Cost as Cost
from fem.budget import cost as cost
from fem.companions import with_companions as with_companions
from fem.interface import BACKWARD as BACKWARD
from fem.interface import FORWARD as FORWARD
from fem.interface import OPEN as OPEN
from fem.interface import STICK as STICK
from fem.model import Model as Model
from fem.model import prepare as prepare
from fem.results import ContactOpening as ContactOpening
from fem.results import EnergyHistory as EnergyHistory
from fem.results import Simulation as Simulation
from fem.results import SlotHistory as SlotHistory
from fem.results import load_simulation as load_simulation
from fem.results import opening_sentence as opening_sentence
from fem.run import simulate as simulate
from fem.settings import Settings as Settings
