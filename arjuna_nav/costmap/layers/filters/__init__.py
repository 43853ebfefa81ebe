"""Layers by masks: zones to keep out of, to drive slowly in, and to switch something in."""
