"""On top of the solvers: command line, judgement, figures, studies."""
