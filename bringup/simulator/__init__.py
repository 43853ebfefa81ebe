"""Commands to a running simulator."""
