"""Studies that make the numbers, tables and schema of the documentation, run from a checkout.

``python -m docs.studies.NAME`` runs one in the folder of slipfront; none is part of the wheel.
"""
