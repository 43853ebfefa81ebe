"""Parameters of the node route_server."""

from __future__ import annotations

from dataclasses import dataclass

from arjuna_core.config import param, plugin_names
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
    aggregate_blocked_ids: bool = param(
        False, "Whether edges that operations found blocked stay so until the goal ends."
    )
    graphs_folder: str = param(".", "Folder that set_route_graph may read from.", path=True)
    route_frame: str = param("map", "Frame of the graph.", read_only=True)
    base_frame: str = param("base_footprint", "The robot's frame.", read_only=True)
    transform_tolerance: float = param(
        1.0, "How old the robot's pose may be.", unit="s", minimum=0.0
    )
    path_density: float = param(0.05, "Between poses of a path.", unit="m", minimum=0.001)
    smooth_corners: bool = param(False, "Whether arcs round the corners of a path.")
    smoothing_radius: float = param(
        1.0, "Radius of these arcs; a corner with no room stays.", unit="m", minimum=0.01
    )
    tracker_update_rate: float = param(
        50.0, "How often progress is looked at.", unit="Hz", minimum=0.1, read_only=True
    )
    radius_to_achieve_node: float = param(
        2.0, "How near to a node the robot passes it.", unit="m", minimum=0.0
    )
    boundary_radius_to_achieve_node: float = param(
        1.0, "How near to the last node it has come there.", unit="m", minimum=0.0
    )
    prune_goal: bool = param(True, "Whether a last node beyond the goal is left out.")
    min_prune_dist_from_start: float = param(
        0.1, "How far along the first edge the robot leaves its node out.", unit="m", minimum=0.0
    )
    min_prune_dist_from_goal: float = param(
        0.15, "How far before the last node a goal leaves it out.", unit="m", minimum=0.0
    )
    max_prune_dist_from_edge: float = param(
        8.0, "How far from an edge that holds.", unit="m", minimum=0.0
    )
    enable_nn_search: bool = param(
        True, "Whether obstacles between a pose and its nearest node make a further one nearer."
    )
    num_nearest_nodes: int = param(5, "Nodes among which it is then looked for.", minimum=1)
    costmap_topic: str = param(
        "global_costmap/costmap_raw", "Costs to look for it by.", read_only=True
    )
