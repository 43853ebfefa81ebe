"""Parameters: from files and options to the nodes."""
