"""Adaptive Monte Carlo localization."""
