"""What users start a scene from: known solids, the parameters they may set, and a TOML template."""
