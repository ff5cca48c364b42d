"""Numbers of problems by name, and problems with other numbers."""
