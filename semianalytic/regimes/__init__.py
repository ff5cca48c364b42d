"""Where the way of slipping changes: thresholds in friction and Poisson ratio, reverse slip."""
