"""Interfaces without a slot, and loads that grow as a power of time: exact where self-similar."""
