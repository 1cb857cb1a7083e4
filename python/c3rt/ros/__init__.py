"""The border to ROS 2: what `c3rt ros` starts. No part of ROS is needed.

What crosses it, and how a ROS node sees it: docs/ros.md. The messages are ROS 2's own, under its names (`rt/joint_states`,
`sensor_msgs::msg::dds_::JointState_`) and with its type hashes. Needs the package cyclonedds: pip install './python[dds]'.
"""
