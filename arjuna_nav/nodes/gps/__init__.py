"""Where the map lies on the earth, from a satellite receiver or a parameter."""
