"""Files that every package reads and writes: maps, YAML, whole or not at all."""
