"""Behavior trees among the nodes: what they ask, which file they are, how they go."""
