"""A client of a running robot: what a person or a script asks of it."""
