"""What another code recorded against the exact answer: units, conventions, norms, verdicts."""

from compare.validation.conventions import Conventions
from compare.validation.validation import Validation, validate

__all__ = ["Conventions", "Validation", "validate"]
