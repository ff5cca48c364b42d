"""Strength that depends on slip rate in any smooth way, by Newton's method for fields."""
