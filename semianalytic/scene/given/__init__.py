"""Helps for writing a scene: known solids, the parameters of a scene, and a TOML template."""
