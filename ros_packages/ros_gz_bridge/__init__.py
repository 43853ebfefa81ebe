"""The bridge's action of launch files, by Jazzy's name."""
