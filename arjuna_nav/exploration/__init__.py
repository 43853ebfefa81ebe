"""Exploration: where to drive so that the map grows."""
