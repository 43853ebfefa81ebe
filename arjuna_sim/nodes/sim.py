"""The simulator as a node: its robots' topics, and the services of a simulator."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from rosgraph_msgs.msg import Clock
from simulation_interfaces.msg import SimulationState
from std_msgs.msg import Float64

from arjuna_core.ros import qos
from arjuna_core.ros.convert import time_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_sim.driven_robot import Observation
from arjuna_sim.files.library import Library
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.inputs import named_robot, named_world
from arjuna_sim.model.robot import SOLO
from arjuna_sim.nodes.camera import WorldTopics
from arjuna_sim.nodes.fleet import Fleet, starts_of
from arjuna_sim.nodes.robot_interface import RobotInterface
from arjuna_sim.nodes.robot_topics import ContactTopic
from arjuna_sim.nodes.run_memory import RunMemory
from arjuna_sim.nodes.services.entities import EntityServices
from arjuna_sim.nodes.services.entity_topics import EntityTopics
from arjuna_sim.nodes.services.gazebo import GazeboServices
from arjuna_sim.nodes.services.known_entities import KnownEntities
from arjuna_sim.nodes.services.simulation import SimulationServices, StepAction
from arjuna_sim.nodes.sim_config import SimConfig
from arjuna_sim.physics.pacing import PaceMeter, Pacer
from arjuna_sim.physics.viewer import Viewer
from arjuna_sim.simulation import Simulation, solo


class SimNode(ManagedNode):
    """Publishes what the simulated robot senses and takes its commands.

    Whoever runs the process calls `tick`: the lock-step driver, or the interactive host when
    `realtime_due` says so.

    Attributes:
        last: What the last tick brought the simulator's own robot; None where it has none.
        fleet: The robots that have nodes and namespaces of their own.
        state: A SimulationState constant: whether simulated time runs.
        library: What clients may name.
        quitting: Whether a client asked the process to end.
        interactive: Whether it runs by the wall clock, rather than tick by tick on demand.
    """

    Config = SimConfig
    DEFAULT_NAME = "sim"
    quitting = False

    def configure(self) -> None:
        """Load robots and world, and create the topics and services."""
        config: SimConfig = self.config
        self.simulator = self._simulation(config)
        self._memory = RunMemory(config.resume_file)
        for note in (*self.simulator.notes, self._memory.resume(self.simulator)):
            if note:
                self.get_logger().warning(note)
        self.last: Observation | None = None
        self.state = SimulationState.STATE_PLAYING
        self.library = Library(config.resource_folder, SearchPath.of())
        self._wall = 0.0
        self.interactive = False
        self._pacer = Pacer(config.real_time_factor, lambda: self._wall)
        self._meter, self._ticks = PaceMeter(), 0
        self._viewer = Viewer() if config.viewer else None
        self._create_topics()
        self._create_services()

    def _simulation(self, config: SimConfig) -> Simulation:
        if config.namespaces:
            starts = starts_of(config)
        else:
            robot = named_robot(config.robot, config.robot_arguments)
            starts = solo(robot, config.initial_pose.asked)
        world = named_world(config.world, [start.robot for start in starts.values()])
        return Simulation(starts, world, config, np.random.default_rng(config.seed))

    def _create_topics(self) -> None:
        self._clock_out = self.publisher(Clock, "/clock", qos.LATEST)
        own = self.simulator.robots.get(SOLO)
        stage, config = self.simulator.stage, replace(self.config, tick=self.simulator.config.tick)
        self._own = None if own is None else RobotInterface(self, own, stage, config)
        self._fixed = WorldTopics(self, self.simulator.fixed, stage)
        self._pace_out = self.publisher(Float64, "real_time_factor", qos.DEFAULT)
        self.fleet = Fleet(self, self.simulator)

    def _create_services(self) -> None:
        known = KnownEntities(self.simulator)
        self._steps = StepAction(self, lambda: self.state)
        answers = SimulationServices(self, self._steps, known.infos.clear).answers
        answers |= EntityServices(self, known).answers
        GazeboServices(self, known, answers, self.simulator.stage)
        EntityTopics(self, known)

    def activate(self) -> None:
        """Restart pacing, and publish the pose of the world."""
        if self._own is not None:
            self._own.begin(self.simulator.time)
        self.fleet.activate()
        self._pacer.restart()
        self._meter.pause()

    def deactivate(self) -> None:
        """End what clients wait for, and say how fast it was."""
        self._steps.abort_all()
        if self._own is not None:
            self._own.close()
        self._fixed.close()
        self.fleet.deactivate()
        self.simulator.close()
        if self._viewer is not None:
            self._viewer.close()
        if self._meter.summary is not None:
            self.get_logger().info(self._meter.summary)

    @property
    def paused(self) -> bool:
        """True while simulated time stands still."""
        return bool(self.state != SimulationState.STATE_PLAYING)

    @property
    def _is_stepping(self) -> bool:
        return self._steps.goal is not None

    def cleanup(self) -> None:
        """Drop the simulation."""
        self.last = self._viewer = None
        self._memory.forget()
        del self.simulator

    def on_config(self, config: Any) -> None:
        """Take a new real-time factor, new limits of the drive and noises of the odometry."""
        self._pacer = Pacer(config.real_time_factor, lambda: self._wall)
        self.simulator.adjust(config)

    def tick(self) -> None:
        """Advance one tick, unless inactive or paused, and publish what it brought."""
        if self.active and (not self.paused or self._is_stepping):
            self.advance()
            self._steps.count()

    def advance(self) -> None:
        """Advance one tick and publish what it brought: time first, transforms before sensors."""
        self._fixed.follow()
        robots = self._interfaces()
        seen = self.simulator.step({name: robot.take_command() for name, robot in robots})
        self._ticks += 1
        self.last = seen.get(SOLO)
        self.publish_time()
        for name, robot in robots:
            robot.publish(seen[name], self.interactive)
        self._fixed.publish(self.simulator.time, self.interactive)
        self._memory.keep(self.simulator.time, seen)

    def _interfaces(self) -> list[tuple[str, RobotInterface]]:
        own = [] if self._own is None else [(SOLO, self._own)]
        return [*own, *((name, nodes.interface) for name, nodes in self.fleet)]

    @property
    def contacts(self) -> ContactTopic:
        """The counter of the contacts of the simulator's own robot."""
        assert self._own is not None
        return self._own.contacts

    def after_reset(self) -> None:
        """Count contacts from zero, and publish the time, which was set back."""
        self.fleet.match()
        for _, robot in self._interfaces():
            robot.contacts.log.reset()
        self.publish_time()

    def publish_time(self) -> None:
        """Publish the time now, in the namespace of each robot too."""
        now = self.simulator.time
        self._clock_out.publish(Clock(clock=time_msg(now)))
        for _, nodes in self.fleet:
            nodes.publish_time(now)

    def realtime_due(self, wall_now: float) -> float:
        """Return the time until the next tick is due.

        Args:
            wall_now: Real time on any steady clock [s].

        Returns:
            Real time to wait [s]; 0 or less means now, inf that no tick will come of itself.
        """
        self.interactive = True
        if self._viewer is not None:
            self._viewer.show(self.simulator.stage.scene.model, self.simulator.stage.data, wall_now)
        if not self.active or self.paused:
            self._pacer.restart()
            self._meter.pause()
            return 0.0 if self.active and self._is_stepping else math.inf
        self._wall = wall_now
        factor = self._meter.update(wall_now, self._ticks * self.simulator.config.tick)
        if factor is not None:
            self._pace_out.publish(Float64(data=factor))
        return self._pacer.wait(self.simulator.time)
