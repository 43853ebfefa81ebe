"""Tests of what a launch file describes, by launch_testing's names; see docs/ci.md."""

from __future__ import annotations

from bringup.ros2.verbs.launch import prepare
from launch_testing import actions, asserts, markers, tools, util
from launch_testing.io_handler import ActiveIoHandler
from launch_testing.parametrize import parametrize
from launch_testing.post_shutdown_test import post_shutdown_test
from launch_testing.proc_info_handler import ActiveProcInfoHandler
from launch_testing.records import IoHandler, ProcInfoHandler

prepare()  # what a file's own imports look up is there, whoever runs it
