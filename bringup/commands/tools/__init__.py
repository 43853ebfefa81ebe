"""Commands that look into the robot and its set-up."""
