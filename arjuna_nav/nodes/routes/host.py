"""The route server as its plug-ins see it."""

from __future__ import annotations

import math
from collections.abc import Callable

from arjuna_core.ros.goal_server import GoalNode
from arjuna_core.ros.tf import TransformError
from arjuna_nav.costmap import Costmap
from arjuna_nav.nodes.costmap.reader import CostmapReader
from arjuna_nav.routes.graph import Graph


class RouteHost(GoalNode):
    """A node that has a graph and tracks routes on it.

    Attributes:
        graph: The graph, None where none is loaded.
    """

    graph: Graph | None = None
    _recheck = False

    @property
    def tracking(self) -> bool:
        """True while a route is tracked."""
        raise NotImplementedError

    def costs_changed(self) -> None:
        """Have a route that is tracked checked for edges that have been closed."""
        self._recheck = True

    def _take_recheck(self) -> bool:
        taken, self._recheck = self._recheck, False
        return taken

    def costmap(self, topic: str) -> Callable[[], Costmap | None]:
        """Return what reads the costmap of a topic in the graph's frame; None is logged."""
        config = self.config
        reader = CostmapReader(self, topic, "", config.base_frame, config.transform_tolerance)

        def read() -> Costmap | None:
            costmap, problem = None, ""
            try:
                costmap = reader.current(math.inf, config.route_frame)
            except TransformError as error:
                problem = str(error)
            if costmap is None:
                why = problem or reader.why_not_current()
                self.get_logger().warning(f"no costmap to see routes by: {why}")
            return costmap

        return read
