"""A generator of robot files as people write them and CAD programs export them."""
