"""What MuJoCo sees: robot, world and entities as one model."""
