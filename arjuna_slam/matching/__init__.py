"""Scan matching: the one stack that mapping and localization use."""
