"""Where results go: whole files, places looked at before anything is computed, leftovers."""
