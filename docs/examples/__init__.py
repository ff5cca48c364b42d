"""Short programs that use slipfront from Python; run one with ``python -m docs.examples.NAME``.

Each writes into the current folder, or into the one given, and prints one line of results.
"""
