"""Commands that compute many scenes: surveys, maps of regimes, stability, the article redone."""
