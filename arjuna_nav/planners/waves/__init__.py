"""Waves over a grid: what it costs to reach each cell, and the way back down."""
