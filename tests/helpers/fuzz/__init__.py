"""Files changed at random, and the readers that must bear them."""
