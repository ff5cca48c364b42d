"""Speed against accuracy of every method on every scene of the chart."""
