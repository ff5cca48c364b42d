"""Parameters of a scene from what gauges recorded: least squares, priors, how well they are known."""
