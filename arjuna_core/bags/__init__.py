"""The one reader and writer of recordings: mcap, rosbag2's SQLite and bags of ROS 1."""
