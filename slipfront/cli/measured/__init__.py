"""Commands that use results of measurements or other codes: fits, validation, benchmarks."""
