"""The belief: weighted particles, how they move and which survive."""
