"""Tasks at waypoints."""
