"""Global planners."""
