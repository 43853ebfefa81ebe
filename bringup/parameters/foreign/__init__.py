"""Parameter files of others, Nav2's, slam_toolbox's and ROS 1's, as ours."""
