"""Processing of what drivers deliver: gamepads, commands, scans, clouds, inertial readings."""
