"""Graceful: a smooth control law that ends at a pose, for following a path and for docking."""
