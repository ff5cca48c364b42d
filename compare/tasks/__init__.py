"""Tasks shared out over processes of this machine (`workers`) or a Dask cluster (`cluster`)."""
