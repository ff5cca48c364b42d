"""Run ``python -m docs.studies.schema``."""

from docs.studies.schema import main

raise SystemExit(main())
