"""A tactile sensor in ROS 2."""
