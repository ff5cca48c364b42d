"""Validate records of other codes against exact answers: units, conventions, norms, verdicts."""

from compare.validation.conventions import Conventions
from compare.validation.validation import Validation, validate

__all__ = ["Conventions", "Validation", "validate"]
