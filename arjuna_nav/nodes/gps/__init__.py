"""The map's datum on the earth, from a satellite receiver or a parameter."""
