"""Field snapshots of a simulation, judged whole: in both bodies, against the exact fields."""
