"""Navigation from Python, as nav2_simple_commander offers it."""
