"""The demo: explore, map, localize, drive, be carried off, drive home."""
