"""The robot's services for maps, costmaps and the lifecycle, as methods."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import PoseStamped
from nav2_msgs.srv import (
    ClearCostmapAroundPose,
    ClearCostmapAroundRobot,
    ClearCostmapExceptRegion,
    ClearEntireCostmap,
    GetCostmap,
    LoadMap,
    ManageLifecycleNodes,
)
from rclpy.node import Node

from nav2_simple_commander.task import SERVER_TIMEOUT, Task

_MANAGER = "nav2_msgs/srv/ManageLifecycleNodes"


class RobotServices(Node):
    """A node with one task at a time, and the services of a robot as methods."""

    def __init__(self, node_name: str, namespace: str) -> None:
        super().__init__(node_name=node_name, namespace=namespace)
        self._task = Task(self)

    def destroyNode(self) -> None:
        self.destroy_node()

    def changeMap(self, map_filepath: str) -> bool:
        answer = self._call(LoadMap, "map_server/load_map", map_url=map_filepath)
        if answer.result != LoadMap.Response.RESULT_SUCCESS:
            self.error(f"Change map request failed with {answer.result}!")
            return False
        self.info("Change map request was successful!")
        return True

    def clearAllCostmaps(self) -> None:
        self.clearLocalCostmap()
        self.clearGlobalCostmap()

    def clearLocalCostmap(self) -> None:
        self._call(ClearEntireCostmap, "local_costmap/clear_entirely_local_costmap")

    def clearGlobalCostmap(self) -> None:
        self._call(ClearEntireCostmap, "global_costmap/clear_entirely_global_costmap")

    def clearCostmapExceptRegion(self, reset_distance: float) -> None:
        name = "local_costmap/clear_costmap_except_region"
        self._call(ClearCostmapExceptRegion, name, reset_distance=float(reset_distance))

    def clearCostmapAroundRobot(self, reset_distance: float) -> None:
        name = "local_costmap/clear_costmap_around_robot"
        self._call(ClearCostmapAroundRobot, name, reset_distance=float(reset_distance))

    def clearLocalCostmapAroundPose(self, pose: PoseStamped, reset_distance: float) -> None:
        self._clear_around("local_costmap", pose, reset_distance)

    def clearGlobalCostmapAroundPose(self, pose: PoseStamped, reset_distance: float) -> None:
        self._clear_around("global_costmap", pose, reset_distance)

    def _clear_around(self, costmap: str, pose: PoseStamped, reset_distance: float) -> None:
        name = f"{costmap}/clear_costmap_around_pose"
        distance = float(reset_distance)
        self._call(ClearCostmapAroundPose, name, pose=pose, reset_distance=distance)

    def getGlobalCostmap(self) -> Any:
        return self._call(GetCostmap, "global_costmap/get_costmap").map

    def getLocalCostmap(self) -> Any:
        return self._call(GetCostmap, "local_costmap/get_costmap").map

    def lifecycleStartup(self) -> None:
        self._manage(ManageLifecycleNodes.Request.STARTUP)

    def lifecycleShutdown(self) -> None:
        self._manage(ManageLifecycleNodes.Request.SHUTDOWN)

    def _manage(self, command: int) -> None:
        """Command every lifecycle manager there is, as the original does."""
        found: list[str] = []

        def managers() -> bool:
            services = self.get_service_names_and_types()
            found[:] = sorted(name for name, types in services if _MANAGER in types)
            return bool(found)

        self._task.run_until(managers, SERVER_TIMEOUT, "a lifecycle manager")
        for name in found:
            self._call(ManageLifecycleNodes, name, command=command)

    def _call(self, service: Any, name: str, **fields: Any) -> Any:
        request = service.Request(**fields)
        return self._task.call(service, name, request, appearance=SERVER_TIMEOUT)

    def info(self, msg: str) -> None:
        self.get_logger().info(msg)

    def warn(self, msg: str) -> None:
        self.get_logger().warn(msg)

    def error(self, msg: str) -> None:
        self.get_logger().error(msg)

    def debug(self, msg: str) -> None:
        self.get_logger().debug(msg)
