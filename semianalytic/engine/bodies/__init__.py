"""Fields in the bodies after a march, summed over wavenumbers and frequencies."""
