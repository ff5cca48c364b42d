"""Maps of how the interface slips over Poisson ratio and friction."""
