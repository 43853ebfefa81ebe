"""The docking server: dock_robot and undock_robot."""
