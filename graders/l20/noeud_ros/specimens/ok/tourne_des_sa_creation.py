import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class ArretUrgence(Node):
    """Un nœud qui ne rend jamais la main : il tourne dans son constructeur."""

    def __init__(self):
        super().__init__("sans_fin")
        self.declare_parameter("distance_min", 0.3)
        self.vitesses = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.recevoir, 10)
        rclpy.spin(self)

    def recevoir(self, scan):
        n = len(scan.ranges)
        for d in scan.ranges[n // 2 - 10 : n // 2 + 10]:
            if not (d > scan.range_min and d < scan.range_max):
                continue
            if d < self.get_parameter("distance_min").value:
                self.vitesses.publish(Twist())
                break
