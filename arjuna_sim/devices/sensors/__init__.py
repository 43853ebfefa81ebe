"""The kinds of sensors, a file each: settings, tags and device, registered there.

These files are read with a robot's file, so none imports MuJoCo or Numba: a device that needs them
stands in a module of its own that `devices/sensor_suite.py` imports.
"""
