"""Checks that a message can be used: finite, of plausible size, its parts consistent."""
