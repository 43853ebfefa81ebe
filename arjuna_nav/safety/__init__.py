"""The last hands on a velocity before it is driven."""
