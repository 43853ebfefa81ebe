"""The window of turtles by which ROS 2's tutorials teach: `ros2 run turtlesim turtlesim_node`."""
