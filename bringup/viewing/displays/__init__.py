"""Displays: one for each kind of message, with the settings that RViz gives it."""
