"""Problem sheets of interfaces: rate-and-state friction, slip weakening, finite contacts."""
