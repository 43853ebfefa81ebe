"""Nav2's own nodes of behavior trees, by its names and ports."""
