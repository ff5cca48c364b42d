"""What agrees with what: predictions, measures, rows of a comparison, its report."""
