"""The orchestrator: `python -m bringup sim|slam|nav|demo`."""
