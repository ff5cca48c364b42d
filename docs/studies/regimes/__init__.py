"""Maps of slip regimes over Poisson ratio and friction."""
