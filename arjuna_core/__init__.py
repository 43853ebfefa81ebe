"""The parts that Arjuna's packages share: geometry, grids, scans, configuration. Free of ROS."""

from arjuna_core.home import use_writable_home
from arjuna_core.shipped_kernels import use_shipped_kernels

use_writable_home()
use_shipped_kernels()
