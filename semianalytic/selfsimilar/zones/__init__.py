"""Which zones slip: guesses, their edges by Newton's method, Coulomb's law, corrections, errors."""
