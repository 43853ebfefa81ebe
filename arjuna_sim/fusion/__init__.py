"""State estimation in space from any sensors: robot_localization's filters, without ROS."""
