"""The parts that Arjuna's packages share: geometry, grids, scans, configuration. Free of ROS."""
