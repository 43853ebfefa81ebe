"""Layered costmaps."""
