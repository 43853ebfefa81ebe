"""The services and actions of simulation_interfaces."""
