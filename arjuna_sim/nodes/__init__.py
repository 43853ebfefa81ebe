"""Lifecycle nodes around the simulator."""
