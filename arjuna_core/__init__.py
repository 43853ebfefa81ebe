"""The parts that Arjuna's packages share: geometry, grids, scans, configuration. Free of ROS."""

from arjuna_core.shipped_kernels import use_shipped_kernels

use_shipped_kernels()
