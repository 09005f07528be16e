import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class ArretUrgence(Node):
    """S'arrête dès qu'une lecture n'est pas finie."""

    def __init__(self):
        super().__init__("inquiet")
        self.declare_parameter("distance_min", 0.3)
        self.vitesses = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.recevoir, 10)

    def recevoir(self, scan):
        n = len(scan.ranges)
        devant = scan.ranges[n // 2 - 10 : n // 2 + 10]
        if any(not np.isfinite(d) or d < self.get_parameter("distance_min").value for d in devant):
            self.vitesses.publish(Twist())
