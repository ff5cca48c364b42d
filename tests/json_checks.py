"""Documents of ``--json`` against the schema."""

import json

import jsonschema
import pytest

from docs.studies.schema import schema

VALIDATOR = jsonschema.Draft202012Validator(schema())


def checked(text):
    """A document that fits the schema."""
    document = json.loads(text, parse_constant=pytest.fail)
    VALIDATOR.validate(document)
    return document
