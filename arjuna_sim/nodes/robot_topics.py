"""The robot's topics: readings of its drive and sensors, and its contacts."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from nav_msgs.msg import Odometry
from rclpy.exceptions import InvalidTopicNameException
from rclpy.validate_topic_name import validate_topic_name
from sensor_msgs.msg import Imu, JointState, LaserScan
from tf2_msgs.msg import TFMessage

from arjuna_core.errors import RobotError
from arjuna_core.ros import qos
from arjuna_core.ros.convert import header, scan_msg, transform_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformPublisher, transforms_msg
from arjuna_core.se2 import SE2
from arjuna_core.timing import Periodic
from arjuna_sim.devices.odometry import OdometryEstimate
from arjuna_sim.devices.sensors.imu import ImuSettings
from arjuna_sim.devices.sensors.lidar import LidarSettings
from arjuna_sim.driven_robot import Observation
from arjuna_sim.inputs import needs_fusion
from arjuna_sim.model.optical import sensor_frame
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.settings import BRIDGES, DriveSettings, GazeboSettings
from arjuna_sim.nodes.messages import WORLD, imu_msg, joint_state_msg, odometry_msg, truth_msg
from arjuna_sim.nodes.sim_config import SimConfig
from arjuna_sim.physics.contacts import ContactLog
from arjuna_sim.physics.robot_motion import JointStates, Truth

TOPIC = "ground_truth/contacts"
_TRUTH = "ground_truth/odom"


class ContactTopic:
    """Publishes a DiagnosticArray with one status when contacts change, and once a second.

    Its level is WARN while the robot touches something beside the ground, else OK; its message
    names what; its values are `count`, the contacts that began since the start, and the count of
    each thing by its name.
    """

    def __init__(self, node: ManagedNode, robot: str) -> None:
        self._robot = robot
        self._out = node.publisher(DiagnosticArray, TOPIC, qos.LATCHED)
        # [s] of simulated time between messages where nothing changes.
        self._due = Periodic(1.0, phase=1.0)
        self.log = ContactLog()

    def update(self, touched: tuple[str, ...], now: float) -> None:
        """Count what the robot touches at a time [s], and publish what is due."""
        changed = self.log.update(touched)
        if self._due.due(now) or changed:
            self._out.publish(contacts_msg(self.log, self._robot, now))


def contacts_msg(log: ContactLog, robot: str, now: float) -> DiagnosticArray:
    """Return counted contacts at a time [s] as a DiagnosticArray message."""
    level = DiagnosticStatus.WARN if log.touched else DiagnosticStatus.OK
    status = DiagnosticStatus(
        level=level,
        name=f"{robot}: contacts",
        message=", ".join(log.touched),
        hardware_id=robot,
        values=[
            KeyValue(key="count", value=str(log.total)),
            *(KeyValue(key=name, value=str(log.counts[name])) for name in sorted(log.counts)),
        ],
    )
    return DiagnosticArray(header=header(WORLD, now), status=[status])


def wheels_alone(drive: DriveSettings, topic: str) -> DriveSettings:
    """Return a drive that leaves odometry and its transform to the filter of wheels and gyro.

    Args:
        topic: Of the wheels' own odometry; the file's if empty.
    """
    publishes = tuple(name for name in drive.publishes if name != "odom_tf")
    topic = topic or drive.odometry_topic
    return dataclasses.replace(drive, odometry_topic=topic, publishes=publishes)


def _with_frames(settings: GazeboSettings, robot: RobotModel) -> GazeboSettings:
    """Return sensors whose frames are where they are; those of cameras are optical ones."""
    sensors = tuple(
        dataclasses.replace(sensor, frame=sensor_frame(robot.urdf, sensor).name)
        for sensor in settings.sensors
    )
    return dataclasses.replace(settings, sensors=sensors)


def _base_frame(robot: RobotModel) -> str:
    """Return the root link where a drive's file names one of the robot's, else what it names.

    Somebody else's robot_state_publisher describes the robot, and may put a name before all links
    (`frame_prefix`), as `robot1/`, or know links that this file has not.
    """
    named, links = robot.drive.base_frame, robot.urdf.links
    prefix, _, link = named.rpartition("/")
    if not named or named in links:
        return robot.urdf.root
    return f"{prefix}/{robot.urdf.root}" if prefix and link in links else named


class RobotTopics:
    """Publishes an observation: transforms before the sensors that need them.

    Attributes:
        settings: The sensors, with their topics.
        drive: The drive, with its topics.
        is_fused: Whether odometry is left to the filter of wheels and gyro.
        fused_topic: On which the filter publishes it.
    """

    def __init__(self, node: ManagedNode, robot: RobotModel, config: SimConfig) -> None:
        robot = robot.standard() if config.standard_topics else robot
        settings, self.drive = robot.settings, robot.drive
        self._begins_in_world = config.frames_of_file and self.drive.begins_in_world
        self._T_world_start: SE2 | None = None
        self.settings = settings if config.frames_of_file else _with_frames(settings, robot)
        self._lidar = self.settings.first(LidarSettings)
        self._imu_settings = self.settings.first(ImuSettings)
        self.is_fused = config.fused_odometry and needs_fusion(robot)
        self.fused_topic = self.drive.fused_topic
        if self.is_fused:
            self.drive = wheels_alone(self.drive, config.wheel_odometry)
        self._base = _base_frame(robot) if config.frames_of_file else robot.urdf.root
        self._tf_out = TransformPublisher(node, "/tf", qos.TF)
        self._truth = config.publish_ground_truth
        self._truth_out: Any = None
        _check_topics(robot.urdf.path, self.drive, self.settings)
        _check_rates(node, self.settings, config)
        self._node = node
        self._create_publishers(node)
        rate = self.drive.rate
        often = max(rate, config.transform_rate) if rate else rate
        self._odom_due = _slower(often if self.is_fused else rate, config.tick)
        self._tf_due = _slower(often, config.tick)
        self._joints_due = _slower(settings.report_rate, config.tick)
        self._bridges_due = Periodic(0.5)  # [s] between two looks at the graph
        self._is_seen = True

    def _create_publishers(self, node: ManagedNode) -> None:
        """Advertise what the robot has: who looks for a topic finds no empty one."""
        if self.drive.wheels and "odom" in self.drive.publishes:
            self._odom_out = node.publisher(Odometry, self.drive.odometry_topic, qos.DEFAULT)
        self._joints_out = node.publisher(JointState, "joint_states", qos.DEFAULT)
        imu, lidar = self._imu_settings, self._lidar
        if imu is not None:
            self._imu_out = node.publisher(Imu, imu.topic, qos.SENSOR_PUBLISHER)
        if lidar is not None:
            self._scan_out = node.publisher(LaserScan, lidar.topic, qos.SENSOR_PUBLISHER)
        if self._truth:
            theirs = {node.process.absolute(sensor.topic) for sensor in self.settings.sensors}
            if node.process.absolute(_TRUTH) not in theirs:  # else the file's own says the same
                self._truth_out = node.publisher(Odometry, _TRUTH, qos.DEFAULT)
            self._static_out = node.publisher(TFMessage, "/tf_static", qos.TF_STATIC)

    def rename_odometry(self, topic: str, other: str) -> bool:
        """Publish the drive's odometry on another topic; return whether it is on the first."""
        absolute, drive = self._node.process.absolute, self.drive
        if "odom" not in drive.publishes or absolute(topic) != absolute(drive.odometry_topic):
            return False
        self.drive = dataclasses.replace(drive, odometry_topic=other)
        self._odom_out = self._node.publisher(Odometry, other, qos.DEFAULT)
        return True

    def publish_static(self, now: float) -> None:
        """Publish where the world is at a time [s]: a map has the world's coordinates."""
        T = transform_msg(SE2(), WORLD, "map", now)
        self._static_out.publish(transforms_msg(T))

    def publish(self, observation: Observation) -> None:
        """Publish what is due of an observation and, if it costs, subscribed to."""
        now = observation.time
        if self.drive.wheels:
            self._publish_odometry(observation)
        if self._joints_due is None or self._joints_due.due(now):
            self._publish_joints(observation.joints, now)
        self._publish_sensors(observation)
        if self._truth_out is not None and self._truth_out.get_subscription_count() > 0:
            self._truth_out.publish(truth_msg(observation.truth, self._base, now))

    def _publish_joints(self, joints: JointStates, now: float) -> None:
        """Publish the states of the joints that the file lists, of all where it lists none."""
        reported = self.settings.reported
        if self._joints_out.get_subscription_count() == 0:
            return
        if reported and reported != joints.names:
            joints = JointStates(reported, *joints.of(reported))
        self._joints_out.publish(joint_state_msg(joints, now))

    def _publish_odometry(self, observation: Observation) -> None:
        drive, now = self.drive, observation.time
        is_due, moves = (due is None or due.due(now) for due in (self._odom_due, self._tf_due))
        estimate = observation.odometry
        if drive.from_world:
            estimate = _exact(observation.truth)
        elif self._begins_in_world:
            estimate = self._in_world(estimate, observation.truth.pose)
        frame = drive.odometry_frame
        if moves and "odom_tf" in drive.publishes and self._is_handed_on(now):
            T = transform_msg(estimate.T_odom_base, frame, self._base, now)
            self._tf_out.publish(transforms_msg(T))
        if is_due and "odom" in drive.publishes:
            self._odom_out.publish(odometry_msg(estimate, frame, self._base, now))

    def _is_handed_on(self, now: float) -> bool:
        """Return whether ROS sees the transform of odometry at a time [s].

        In Gazebo Sim it is a topic as others are: where bridges are, and none of them hands it on,
        a filter or a node of the user's publishes it.
        """
        if self.drive.is_bridged and self._bridges_due.due(now):
            count, before = self._node.count_publishers, self._is_seen
            self._is_seen = not count(BRIDGES) or count(f"{BRIDGES}/tf") > 0
            if before and not self._is_seen:
                frames = f"{self.drive.odometry_frame} -> {self._base}"
                reason = f"{frames} is left to others, as no bridge hands Gazebo's transforms on"
                self._node.get_logger().info(reason)
        return self._is_seen

    def _in_world(self, estimate: OdometryEstimate, pose: SE2) -> OdometryEstimate:
        """Return odometry that began at the robot's pose in the world, where it was put."""
        if self._T_world_start is None:
            self._T_world_start = pose @ estimate.T_odom_base.inverse()
        turn = SE2(theta=self._T_world_start.theta).matrix()
        return estimate._replace(
            T_odom_base=self._T_world_start @ estimate.T_odom_base,
            covariance=turn @ estimate.covariance @ turn.T,
        )

    def _publish_sensors(self, observation: Observation) -> None:
        lidar, imu = self._lidar, self._imu_settings
        if observation.imu is not None and self._imu_out.get_subscription_count() > 0:
            assert imu is not None
            for reading in (*observation.imu_before, observation.imu):
                self._imu_out.publish(imu_msg(reading, imu.frame, reading.stamp))
        if observation.scan is not None:
            assert lidar is not None
            self._scan_out.publish(scan_msg(observation.scan, lidar.frame, 1.0 / lidar.rate))


def _check_topics(path: Path, drive: DriveSettings, settings: GazeboSettings) -> None:
    sensors = (sensor.topic for sensor in settings.sensors)
    for topic in (drive.command_topic, drive.odometry_topic, *sensors):
        try:
            validate_topic_name(topic)
        except InvalidTopicNameException as error:
            problem = f"'{topic}' is no topic's name; standard_topics: true goes without it"
            raise RobotError(path, problem) from error


def _check_rates(node: ManagedNode, settings: GazeboSettings, config: SimConfig) -> None:
    for sensor in settings.sensors:
        is_imu = sensor.is_first and isinstance(sensor, ImuSettings)
        period = config.physics_timestep if is_imu else config.tick
        if sensor.rate > 1.0 / period + 1e-9:
            name = type(sensor).TITLE if sensor.is_first else f"sensor {sensor.name}"
            node.get_logger().warning(
                f"the {name} has {sensor.rate:g} Hz, but comes at {1.0 / period:g} Hz at most"
            )


def _slower(rate: float, tick: float) -> Periodic | None:
    """Return when something slower than the tick is due; None for each tick."""
    if rate <= 0.0 or 1.0 / rate <= tick + 1e-9:
        return None
    return Periodic(1.0 / rate, phase=1.0 / rate)


def _exact(truth: Truth) -> OdometryEstimate:
    """Return the truth as odometry, as a drive with world odometry publishes it."""
    return OdometryEstimate(truth.pose, truth.v, truth.w, np.zeros((3, 3)), (0.0, 0.0), truth.side)
