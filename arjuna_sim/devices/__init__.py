"""What a robot has: its drive, its sensors and what it makes of them."""
