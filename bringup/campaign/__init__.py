"""Campaigns: many runs of one command, their outcomes, and what they say together."""
