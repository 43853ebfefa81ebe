"""Pose graphs: what they hold, how they are optimised and how loops are closed."""
