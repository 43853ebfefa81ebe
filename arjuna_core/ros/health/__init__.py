"""What a process does about what goes wrong in it: caught, refused, counted, reported."""
