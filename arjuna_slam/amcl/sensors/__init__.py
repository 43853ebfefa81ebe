"""How likely a scan is at each particle."""
