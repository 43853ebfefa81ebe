"""Robot, world and entities as one MuJoCo model."""
