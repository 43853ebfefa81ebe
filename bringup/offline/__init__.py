"""What runs without ROS: SLAM and AMCL on logs, calibration."""
