"""Worlds and models: SDF."""
