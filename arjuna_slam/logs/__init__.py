"""Logs and recordings: scans and odometry in."""
