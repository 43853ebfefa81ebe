"""Tests of what nodes share, without ROS."""
