"""Goals on their way into the navigator."""
