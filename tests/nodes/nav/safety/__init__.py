"""The collision monitor's and the collision detector's own."""
