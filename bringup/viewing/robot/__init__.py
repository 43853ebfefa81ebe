"""The ROS side of a viewer."""
