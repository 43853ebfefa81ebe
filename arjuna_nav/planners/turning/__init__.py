"""Ways of a robot that drives straight, ahead and back, and turns on the spot."""
