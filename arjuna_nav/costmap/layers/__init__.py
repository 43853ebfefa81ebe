"""Layers of a costmap, a file each, and the list of them."""
