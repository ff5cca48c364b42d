"""How commands end when they do not succeed: refusals in one sentence, interruptions, faults."""
