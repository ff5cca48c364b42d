"""Opening of the contact: the normal problem, in which gap or pressure is zero everywhere."""
