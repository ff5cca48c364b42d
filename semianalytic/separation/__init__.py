"""Where the contact opens: the normal problem alone, gap and pressure >= 0, one of them zero."""
