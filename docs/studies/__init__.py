"""Studies that make the numbers, tables and schema of the documentation.

They run from a checkout, as ``python -m docs.studies.NAME`` in its root; no wheel contains them.
"""
