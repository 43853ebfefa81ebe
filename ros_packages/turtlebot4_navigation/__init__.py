"""Navigation of a TurtleBot 4 from Python, as turtlebot4_navigation offers it."""
