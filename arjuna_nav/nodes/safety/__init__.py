"""What the collision monitor and the collision detector share."""
