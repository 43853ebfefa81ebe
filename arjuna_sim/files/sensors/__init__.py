"""A robot's sensors, as Gazebo tags them."""
