"""Submaps, maps and sessions."""
