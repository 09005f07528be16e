import rclpy
from collections import deque
from geometry_msgs.msg import Twist
from rclpy.node import Node
from std_msgs.msg import Bool, Float32
from sensor_msgs.msg import LaserScan


class ArretUrgence(Node):
    """Retient les trois derniers scans, et s'arrête si deux au moins montrent un obstacle."""

    def __init__(self):
        super().__init__("confirme")
        self.declare_parameter("distance_min", 0.3)
        self.vitesses = self.create_publisher(Twist, "/cmd_vel", 10)
        self.plus_proche = self.create_publisher(Float32, "/plus_proche", 10)
        self.danger = self.create_publisher(Bool, "/danger", 10)
        self.vus = deque(maxlen=3)
        self.create_subscription(LaserScan, "/scan", self.recevoir, 10)

    def recevoir(self, scan):
        n = len(scan.ranges)
        valides = [float(d) for d in scan.ranges[n // 2 - 10 : n // 2 + 10] if scan.range_min < d < scan.range_max]
        if valides:
            self.plus_proche.publish(Float32(data=min(valides)))
        self.vus.append(bool(valides) and min(valides) < self.get_parameter("distance_min").value)
        self.danger.publish(Bool(data=self.vus[-1]))
        if sum(self.vus) >= 2:
            self.vitesses.publish(Twist())
            self.get_logger().info("STOP", throttle_duration_sec=1.0)
