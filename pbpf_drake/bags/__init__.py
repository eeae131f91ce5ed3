"""Recorded files and the messages in them, without ROS and without Drake."""
