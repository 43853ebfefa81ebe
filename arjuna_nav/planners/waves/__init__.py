"""Waves over a grid: the cost to reach each cell, and the descent back."""
