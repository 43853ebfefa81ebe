"""Parameters of the node route_server."""

from __future__ import annotations

from dataclasses import dataclass

from arjuna_core.config import duration_param, fixed, length_param, param, plugin_names
from arjuna_nav.nodes.routes.plugins import OPERATIONS, SCORERS


@dataclass(frozen=True)
class RouteServerConfig:
    """Parameters of the node `route_server`, by Nav2's names."""

    graph_filepath: str = param(
        "", "The graph, a GeoJSON file; empty: set by a service.", path=True
    )
    edge_cost_functions: tuple[str, ...] = plugin_names(
        ("DistanceScorer", "DynamicEdgesScorer"), "Scorers of edges.", SCORERS
    )
    operations: tuple[str, ...] = plugin_names(
        ("AdjustSpeedLimit", "ReroutingService"), "Operations on a tracked route.", OPERATIONS
    )
    max_iterations: int = param(
        0, "Greatest number of nodes that a search looks at; any number up to 0."
    )
    aggregate_blocked_ids: bool = param(
        False, "Whether edges that operations found blocked stay so until the goal ends."
    )
    graphs_folder: str = param(".", "Folder that set_route_graph may read from.", path=True)
    route_frame: str = fixed("map", "Frame of the graph.")
    base_frame: str = fixed("base_footprint", "The robot's frame.")
    transform_tolerance: float = duration_param(1.0, "How old the robot's pose may be.")
    path_density: float = length_param(0.05, "Between poses of a path.", minimum=0.001)
    smooth_corners: bool = param(False, "Whether arcs round the corners of a path.")
    smoothing_radius: float = length_param(
        1.0, "Radius of these arcs; a corner with no room stays.", minimum=0.01
    )
    tracker_update_rate: float = fixed(
        50.0, "How often progress is looked at.", unit="Hz", minimum=0.1
    )
    radius_to_achieve_node: float = length_param(2.0, "How near to a node the robot passes it.")
    boundary_radius_to_achieve_node: float = length_param(
        1.0, "How near to the last node it has come there."
    )
    prune_goal: bool = param(True, "Whether a last node beyond the goal is left out.")
    min_prune_dist_from_start: float = length_param(
        0.1, "How far along the first edge the robot leaves its node out."
    )
    min_prune_dist_from_goal: float = length_param(
        0.15, "How far before the last node a goal leaves it out."
    )
    max_prune_dist_from_edge: float = length_param(8.0, "How far from an edge that holds.")
    enable_nn_search: bool = param(
        True, "Whether obstacles between a pose and its nearest node make a further one nearer."
    )
    num_nearest_nodes: int = param(5, "Nodes among which it is then looked for.", minimum=1)
    costmap_topic: str = fixed("global_costmap/costmap_raw", "Costs to look for it by.")
