"""Parallel tasks in processes of this machine (`workers`) or on a Dask cluster (`cluster`)."""
