"""Scenes to drive in, made up by seed or shipped, and drives in them judged by the truth."""
