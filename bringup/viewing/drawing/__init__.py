"""Drawings as plain values: no ROS, no window."""
