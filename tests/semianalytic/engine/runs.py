"""Runs that tests of interfaces share."""

import semianalytic as sf


def one_run(face, end_time, nodes, **given):
    """A run on one grid, without others to estimate its error by."""
    return sf.solve(face, end_time=end_time, nodes=nodes, estimate=False, **given)
