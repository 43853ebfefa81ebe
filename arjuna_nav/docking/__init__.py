"""Docking and undocking: docks, the approach, and the order of things."""
