"""Read interface results of other codes from files into records at stations."""
