"""What users hand over for a scene: quantities with units, tables of loads, known solids."""
