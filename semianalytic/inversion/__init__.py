"""Parameters of a scene from what gauges recorded: least squares, priors, how far they hold."""
