"""The way on where a controller finds none: straight, back and turns on the spot."""
