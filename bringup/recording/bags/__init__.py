"""Recordings as files: written, read, mended; no ROS."""
