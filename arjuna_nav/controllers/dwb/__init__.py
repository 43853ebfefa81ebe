"""DWB: sampled velocities, simulated and scored by critics."""
