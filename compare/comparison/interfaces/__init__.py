"""Interfaces by both methods: run, simulated with finite elements on three meshes, and judged."""
