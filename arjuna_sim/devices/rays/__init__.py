"""Rays and the first surface on each."""
