"""How accurate the finite elements and the marcher are, and what that costs."""
