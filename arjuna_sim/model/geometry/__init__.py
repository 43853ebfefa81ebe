"""Shapes: what they are, what they weigh, and what they are cut into."""
