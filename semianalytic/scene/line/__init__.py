"""Properties along the line y = 0: contacts, fields, and loads of any place and time."""
