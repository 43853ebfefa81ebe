"""Nodes of robot_localization: its two filters and the conversion of GPS."""
