"""Robots, worlds and entities as plain values."""
