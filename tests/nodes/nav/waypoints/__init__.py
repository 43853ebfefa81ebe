"""What is done at each waypoint."""
