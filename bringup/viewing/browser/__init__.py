"""RViz's part in a browser: the robot, its map and its plans, and tools to command it."""
