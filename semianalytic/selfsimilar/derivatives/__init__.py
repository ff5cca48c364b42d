"""Derivatives of zones and fields with respect to the parameters of a scene."""
