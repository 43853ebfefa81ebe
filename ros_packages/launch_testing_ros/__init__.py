"""Waiting for topics in launch tests, by launch_testing_ros' names."""

from launch_testing_ros import actions, tools
from launch_testing_ros.wait_for_topics import MessagePattern, WaitForTopics
