"""Costmaps as lifecycle nodes."""
