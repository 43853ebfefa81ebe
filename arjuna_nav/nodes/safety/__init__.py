"""The collision detector, and sources and zones shared with the collision monitor."""
