"""Smac Hybrid-A*: paths that a car could drive."""
