"""Element families, what they assemble, and where the edge of a contact lies among their nodes."""
