"""The lifecycle manager of a group of nodes."""
