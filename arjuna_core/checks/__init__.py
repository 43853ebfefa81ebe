"""Whether a message can be used: finite, of plausible size, and its parts fit each other."""
