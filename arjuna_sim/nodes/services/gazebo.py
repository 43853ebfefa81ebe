"""Gazebo's own services, which some clients call: gazebo_msgs', and ros_gz_interfaces' of a world.

The node `gzserver` of ros_gz_sim has simulation_interfaces' services below its name: these too.

Some have the names of simulation_interfaces' services and other types. A participant knows a name
by one type, so that they live in one of their own, made when a client of theirs is seen. Those of a
world, and the plain ones of std_srvs, have the names by which clients ask.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Pose, PoseStamped, Twist
from rclpy.clock import Clock, ClockType
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node, NodeNameNonExistentError
from simulation_interfaces.msg import EntityState, Resource, Result, SimulationState
from simulation_interfaces.srv import (
    DeleteEntity,
    GetEntityState,
    GetSimulationState,
    ResetSimulation,
    SetEntityState,
    SetSimulationState,
    SpawnEntity,
    StepSimulation,
)
from std_msgs.msg import Header

from arjuna_core.readings import seconds
from arjuna_core.ros.context import class_of, discovery, new_context
from arjuna_core.ros.convert import header, pose3_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_sim.model.entities import EntityError
from arjuna_sim.nodes.messages import WORLD, pose3_from_msg
from arjuna_sim.nodes.services.known_entities import KnownEntities
from arjuna_sim.physics.stage import Stage

_WORLDS = ("", "world", "map")
"""Names of the world's frame."""
_CLASSIC, _OF_WORLDS, _EMPTY = "gazebo_msgs", "ros_gz_interfaces", "std_srvs/srv/Empty"
_STANDARD, _SERVER = "simulation_interfaces", "gzserver"
_PERIODS = 0.2, 0.05, 0.002  # of looking for clients, of polling for requests, and for pushes [s]
_PUSHES = {"apply_joint_effort", "apply_link_wrench", "clear_joint_efforts", "clear_link_wrenches"}
"""What programs call in each step of their control loops."""


class GazeboServices:
    """Answers Gazebo's services by those of simulation_interfaces, given by name.

    Attributes:
        bridged: What answers those of ros_gz_interfaces, by their types.
        classic: What answers Gazebo classic's of gazebo_msgs, by their names.
        plain: What answers Gazebo classic's of std_srvs/srv/Empty, by their names.
    """

    def __init__(
        self,
        node: ManagedNode,
        known: KnownEntities,
        answers: Mapping[str, Callable[[Any, Any], Any]],
        stage: Stage,
    ) -> None:
        self._node, self._known, self._answers, self._stage = node, known, answers, stage
        self.bridged: dict[str, Callable[[Any, Any], Any]] = {
            "SpawnEntity": self._create,
            "DeleteEntity": self._remove,
            "SetEntityPose": self._set_pose,
            "ControlWorld": self._control,
        }
        self.classic: dict[str, Callable[[Any, Any], Any]] = {
            "spawn_entity": self._spawn,
            "delete_entity": self._delete,
            "get_entity_state": self._get_state,
            "set_entity_state": self._set_state,
            "get_model_list": self._list,
            "apply_joint_effort": self._push_joint,
            "apply_link_wrench": self._push_link,
            "clear_joint_efforts": self._clear_joint,
            "clear_link_wrenches": self._clear_link,
        }
        self.plain: dict[str, Callable[[], str]] = {
            "reset_simulation": lambda: self._reset(ResetSimulation.Request.SCOPE_ALL),
            "reset_world": lambda: self._reset(ResetSimulation.Request.SCOPE_STATE),
            "pause_physics": lambda: self._hold(True),
            "unpause_physics": lambda: self._hold(False),
        }
        self._own: Node | None = None
        self._executor: EventsExecutor | None = None
        self._timers: list[Any] = []
        self._known_services: set[tuple[str, str]] = set()
        self._answered, self._is_soon = 0, False
        if node.transport is None:  # else there are no clients but those of this process
            self._every(_PERIODS[0], self._look)
        node.keep(self)

    def _every(self, period: float, then: Callable[[], None]) -> None:
        """Call a function in a period [s] of the wall's clock."""
        clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._timers.append(self._node.create_timer(period, then, clock=clock))

    def destroy(self) -> None:
        """Leave the graph."""
        for timer in self._timers:
            self._node.destroy_timer(timer)
        if self._own is not None and self._executor is not None:
            self._executor.shutdown()
            self._own.destroy_node()
            self._own.context.shutdown()
            self._own = None

    def _look(self) -> None:
        """Serve what there are clients of, and is not served yet.

        No more than that: ten services at once reach a client by Fast DDS' next heartbeat alone,
        3 s later, when programs that wait for a second or two have given up.
        """
        for name, kind in sorted(self._wanted() - self._known_services):
            if (answer := self._answer_of(name, kind)) is not None:
                self._serve([(class_of(kind), name, answer)])
            self._known_services.add((name, kind))

    def _answer_of(self, name: str, kind: str) -> Callable[[Any, Any], Any] | None:
        package, _, short = kind.split("/")
        if package == _OF_WORLDS:
            return self.bridged.get(short)
        last = name.rpartition("/")[2]
        if package == _CLASSIC:
            return self.classic.get(last)
        if package == _STANDARD:
            return self._of_server(last) if name == self._below_server(last) else None
        do = self.plain.get(last) if kind == _EMPTY else None
        return None if do is None else lambda request, response: self._plainly(do, response)

    def _below_server(self, name: str) -> str:
        """Return the full name that a service of Gazebo's node has."""
        return f"/{self._node.process.namespace}/{_SERVER}/{name}".replace("//", "/")

    def _of_server(self, name: str) -> Callable[[Any, Any], Any] | None:
        """Return what answers a standard service; Gazebo sets pose and twist unasked."""
        answer = self._answers.get(name)
        if name != "set_entity_state" or answer is None:
            return answer

        def set_both(request: Any, response: Any) -> Any:
            if not (request.set_pose or request.set_twist or request.set_acceleration):
                request.set_pose, request.set_twist = True, request.state.twist != Twist()
            return answer(request, response)

        return set_both

    def _wanted(self) -> set[tuple[str, str]]:
        """Return the names and types of services that clients ask for."""
        node, found = self._node, set()
        for name, space in node.get_node_names_and_namespaces():
            try:
                clients = node.get_client_names_and_types_by_node(name, space)
            except NodeNameNonExistentError:  # it has left since
                continue
            found |= {(service, kind) for service, kinds in clients for kind in kinds}
        return found

    def _serve(self, services: Iterable[tuple[Any, str, Callable[[Any, Any], Any]]]) -> None:
        if self._own is None:
            with discovery(isolated=False):
                context = new_context()
                namespace = self._node.process.namespace
                self._own = Node("gazebo", context=context, namespace=namespace)
            executor = self._executor = EventsExecutor(context=context)
            executor.add_node(self._own)
            self._every(_PERIODS[1], self._poll)
        for kind, name, answer in services:
            self._own.create_service(kind, name, self._counted(self._node.answering(name, answer)))
            if name.rpartition("/")[2] in _PUSHES and not self._is_soon:
                self._is_soon = True
                self._every(_PERIODS[2], self._poll)
            self._node.get_logger().info(f"{name} is there, for a client asks for Gazebo's")

    def _counted(self, answer: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
        def answered(request: Any, response: Any) -> Any:
            self._answered += 1
            return answer(request, response)

        return answered

    def _poll(self) -> None:
        """Answer the requests that wait, but no more than leave time for the simulation."""
        assert self._executor is not None
        for _ in range(50):
            before = self._answered
            self._executor.spin_once(0.0)
            if self._answered == before:
                return

    def _ask(self, service: str, kind: Any, /, **fields: Any) -> tuple[Any, str]:
        """Return the response of a service of simulation_interfaces, and why it failed."""
        response = self._answers[service](kind.Request(**fields), kind.Response())
        is_done = response.result.result == Result.RESULT_OK
        return response, "" if is_done else response.result.error_message or "it failed"

    def _spawn(self, request: Any, response: Any) -> Any:
        answer, problem = self._ask(
            *("spawn_entity", SpawnEntity),
            name=request.name,
            allow_renaming=not request.name,
            entity_namespace=request.robot_namespace,
            entity_resource=Resource(resource_string=request.xml),
            initial_pose=_stamped(PoseStamped, request.initial_pose, request.reference_frame),
        )
        done = f"SpawnEntity: Successfully spawned entity [{answer.entity_name}]"
        response.success, response.status_message = not problem, problem or done
        return response

    def _delete(self, request: Any, response: Any) -> Any:
        _, problem = self._ask("delete_entity", DeleteEntity, entity=request.name)
        done = f"DeleteEntity: Successfully deleted entity [{request.name}]"
        response.success, response.status_message = not problem, problem or done
        return response

    def _get_state(self, request: Any, response: Any) -> Any:
        found, problem = self._ask("get_entity_state", GetEntityState, entity=request.name)
        response.header = header(request.reference_frame or WORLD, self._node.now)
        if problem:
            return response
        pose, twist = found.state.pose, found.state.twist
        frame = _frame(request.reference_frame)
        if frame:
            other, problem = self._ask("get_entity_state", GetEntityState, entity=frame)
            if problem:
                return response
            T_world_frame = pose3_from_msg(other.state.pose)
            pose = pose3_msg(T_world_frame.inverse() @ pose3_from_msg(pose))
            for vector in (twist.linear, twist.angular):
                turned = T_world_frame.rotation().T @ np.array([vector.x, vector.y, vector.z])
                vector.x, vector.y, vector.z = turned.tolist()
        response.state.name, response.state.reference_frame = request.name, request.reference_frame
        response.state.pose, response.state.twist = pose, twist
        response.success = True
        return response

    def _set_state(self, request: Any, response: Any) -> Any:
        state = _stamped(EntityState, request.state.pose, request.state.reference_frame)
        state.twist = request.state.twist
        fields = {"entity": request.state.name, "state": state}
        _, problem = self._ask("set_entity_state", SetEntityState, set_pose=True, **fields)
        refused = problem
        if not problem and state.twist != Twist():  # what was put somewhere rests otherwise
            _, refused = self._ask("set_entity_state", SetEntityState, set_twist=True, **fields)
        if refused:
            self._node.get_logger().warning(f"set_entity_state: {refused}")
        response.success = not problem
        return response

    def _done(self, response: Any, *problems: str) -> Any:
        """Return a response of a world's service, which cannot say why it failed: the log does."""
        found = [problem for problem in problems if problem]
        for problem in found:
            self._node.get_logger().warning(f"{type(response).__name__}: {problem}")
        response.success = not found
        return response

    def _create(self, request: Any, response: Any) -> Any:
        made = request.entity_factory
        _, problem = self._ask(
            *("spawn_entity", SpawnEntity),
            name=made.name,
            allow_renaming=made.allow_renaming or not made.name,
            entity_resource=Resource(uri=made.sdf_filename, resource_string=made.sdf),
            initial_pose=_stamped(PoseStamped, made.pose, made.relative_to),
        )
        return self._done(response, problem)

    def _remove(self, request: Any, response: Any) -> Any:
        return self._done(
            response, self._ask("delete_entity", DeleteEntity, entity=request.entity.name)[1]
        )

    def _set_pose(self, request: Any, response: Any) -> Any:
        fields = {"entity": request.entity.name, "set_pose": True}
        state = _stamped(EntityState, request.pose, "")
        return self._done(
            response, self._ask("set_entity_state", SetEntityState, state=state, **fields)[1]
        )

    def _control(self, request: Any, response: Any) -> Any:
        """Set back, stop, go on or step, in that order, as gz-sim's service `control`."""
        asked, kind, problems = request.world_control, ResetSimulation.Request, []
        scope = asked.reset.time_only * kind.SCOPE_TIME + asked.reset.model_only * kind.SCOPE_STATE
        scope = kind.SCOPE_ALL if asked.reset.all else scope
        if scope:
            problems.append(self._reset(scope))
        steps = asked.multi_step or int(asked.step)
        problems.append(self._hold(bool(asked.pause or steps)))
        if steps:
            problems.append(self._ask("step_simulation", StepSimulation, steps=steps)[1])
        if asked.seed or asked.run_to_sim_time != Time():
            problems.append("seed and run_to_sim_time have no effect")
        return self._done(response, *problems)

    def _reset(self, scope: int) -> str:
        return self._ask("reset_simulation", ResetSimulation, scope=scope)[1]

    def _hold(self, is_held: bool) -> str:
        kind = SimulationState
        state = kind(state=kind.STATE_PAUSED if is_held else kind.STATE_PLAYING)
        if self._ask("get_simulation_state", GetSimulationState)[0].state == state:
            return ""
        return self._ask("set_simulation_state", SetSimulationState, state=state)[1]

    def _plainly(self, do: Callable[[], str], response: Any) -> Any:
        if problem := do():
            self._node.get_logger().warning(problem)
        return response

    def _list(self, request: Any, response: Any) -> Any:
        response.header = header(WORLD, self._node.now)
        response.model_names = [entity.name for entity in self._known.all()]
        response.success = True
        return response

    def _push_joint(self, request: Any, response: Any) -> Any:
        push = self._stage.forces.push_joint
        return self._pushed(request, response, push, request.joint_name, request.effort)

    def _push_link(self, request: Any, response: Any) -> Any:
        force, torque, at = request.wrench.force, request.wrench.torque, request.reference_point
        push, frame = self._stage.forces.push_link, _frame(request.reference_frame)
        wrench = np.array([force.x, force.y, force.z, torque.x, torque.y, torque.z])
        point = np.array([at.x, at.y, at.z])
        return self._pushed(request, response, push, request.link_name, wrench, frame, point)

    def _pushed(self, request: Any, response: Any, push: Callable[..., None], *what: Any) -> Any:
        """Answer a request to push something for its time, of which none is none."""
        lasts, problem = seconds(request.duration), ""
        begin = self._stage.elapsed + max(0.0, seconds(request.start_time) - self._node.now)
        try:
            push(*what, begin, math.inf if lasts < 0.0 else begin + lasts)
        except EntityError as error:
            problem = str(error)
        response.success, response.status_message = not problem, problem
        return response

    def _clear_joint(self, request: Any, response: Any) -> Any:
        return self._cleared(self._stage.forces.clear_joint, request.joint_name, response)

    def _clear_link(self, request: Any, response: Any) -> Any:
        return self._cleared(self._stage.forces.clear_link, request.link_name, response)

    def _cleared(self, clear: Callable[[str], None], name: str, response: Any) -> Any:
        """Answer a request to push something no more, which cannot say why it failed."""
        try:
            clear(name)
        except EntityError as error:
            self._node.get_logger().warning(str(error))
        return response


def _frame(name: str) -> str:
    """Return a frame as simulation_interfaces names it."""
    return "" if name in _WORLDS else name


def _stamped(kind: Any, pose: Pose, frame: str) -> Any:
    """Return a message of a pose in a frame that Gazebo's client names."""
    return kind(header=Header(frame_id=_frame(frame)), pose=pose)
