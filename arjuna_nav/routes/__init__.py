"""Routes on a graph of places and the ways between them."""
