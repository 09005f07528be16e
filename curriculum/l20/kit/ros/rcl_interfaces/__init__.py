"""Messages internes de ROS 2."""
