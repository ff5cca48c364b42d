# The public names of this package and where they are defined; `semianalytic.names` reads this list.

from compare.comparison.judgement import Judgement as Judgement
from compare.comparison.judgement import judge as judge
from compare.comparison.mesh_choice import MeshChoice as MeshChoice
from compare.comparison.mesh_choice import Unseen as Unseen
from compare.comparison.mesh_choice import choose_mesh as choose_mesh
from compare.comparison.rows import Row as Row
