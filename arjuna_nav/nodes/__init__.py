"""Lifecycle nodes around the navigation cores."""
