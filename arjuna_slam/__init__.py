"""Pose-graph SLAM and Monte Carlo localization. Free of ROS outside `nodes`."""
