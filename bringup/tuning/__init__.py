"""Parameters tuned by machine: a search space, its trials, and what mattered."""
