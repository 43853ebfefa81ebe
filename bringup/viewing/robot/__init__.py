"""The ROS side of a viewer: what it hears, and what it says for a person."""
