"""Comparisons of the engine with codes that others wrote, for docs/peers.md.

Each module runs one peer, or reads what it published, runs the same problem with `semianalytic`
and writes its rows of docs/data/peers.csv.  Programs and files of the peers are named on the
command line; none of them is part of this package.
"""
