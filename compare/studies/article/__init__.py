"""The article done again: its cases, its claims, how each is judged."""
