"""How far the judge of a comparison can be trusted: trials, spoilt answers, their tables."""
