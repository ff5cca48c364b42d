"""The branch cut in slowness: panels on it, the canonical function, the fields of given zones."""
