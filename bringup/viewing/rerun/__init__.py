"""Recordings and running robots in rerun."""
