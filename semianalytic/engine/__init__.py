"""Real interfaces: finite contacts, fields along x, friction with state, steps of any length."""
