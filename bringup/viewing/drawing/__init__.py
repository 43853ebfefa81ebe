"""What a viewer draws, as plain values: no ROS, no window."""
