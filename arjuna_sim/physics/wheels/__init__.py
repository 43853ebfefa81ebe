"""Wheels and how they stand, roll, slip and are driven."""
