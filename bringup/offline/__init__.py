"""Programs that need no ROS: SLAM and AMCL on logs, calibration."""
