"""Run ``python -m docs.studies.schema``."""

from docs.studies.schema import write

write()
