"""Builds ROS 2 interface packages with the official generators and a C/C++ compiler."""
