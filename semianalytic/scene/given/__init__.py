"""How scenes are given: by name, in files and tables, and helps for writing them."""
