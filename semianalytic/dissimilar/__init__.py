"""Two different half-planes: when friction has an answer at all, and the exact answer."""
