"""Random and hostile files and messages."""
