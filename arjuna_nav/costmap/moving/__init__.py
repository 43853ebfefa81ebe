"""Things that move, found in scans."""
