"""Commands on what others measured or computed: fits, validation, benchmarks."""
