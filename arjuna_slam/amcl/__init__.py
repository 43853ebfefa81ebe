"""Adaptive Monte Carlo localization: where the robot is in a known map."""
