"""Lifecycle nodes around SLAM, AMCL and maps."""
