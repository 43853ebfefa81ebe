"""Devices of a robot: its drive, its sensors and its odometry."""
