"""The trial of `slipfront validate`: files that are right, wrong or junk, made from our answers."""
