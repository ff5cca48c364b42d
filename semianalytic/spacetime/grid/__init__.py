"""The nodes of a march: what they resolve, the loads on them, and friction at each."""
