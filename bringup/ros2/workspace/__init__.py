"""Workspaces of packages: built, tested and sourced where nothing has to be compiled."""
