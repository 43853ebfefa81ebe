"""Topics, actions and services of the controllers of a robot's joints."""
