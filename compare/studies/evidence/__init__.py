"""The evidence page: one HTML file with every scene, method and figure."""
