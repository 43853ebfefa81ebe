"""Scorers and operations of route_server that speak ROS, and the lists of all."""
