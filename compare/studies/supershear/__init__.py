"""Ruptures that weaken with slip: where they overtake shear waves."""
