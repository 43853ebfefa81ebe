"""Topics in launch tests, by launch_testing_ros' names."""

from launch_testing_ros import actions, tools
from launch_testing_ros.data_republisher import DataRepublisher
from launch_testing_ros.message_pump import MessagePump
from launch_testing_ros.wait_for_topics import MessagePattern, WaitForTopics
