"""Routes on a graph."""
