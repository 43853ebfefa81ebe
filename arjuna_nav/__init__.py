"""Costmaps, planners, controllers, behaviours, navigator. Free of ROS outside `nodes`."""
