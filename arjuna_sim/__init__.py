"""MuJoCo simulation of a skid-steer robot in a world. Free of ROS outside `nodes`."""
