"""Speed against accuracy: every method on every scene."""
