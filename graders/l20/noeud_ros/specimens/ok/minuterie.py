import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class ArretUrgence(Node):
    """Le scan décide, une minuterie publie."""

    def __init__(self):
        super().__init__("arret")
        self.danger = False
        self.declare_parameter("distance_min", 0.3)
        self.vitesses = self.create_publisher(Twist, "/cmd_vel", 10)
        self.sub = self.create_subscription(LaserScan, "/scan", self.scan, 10)
        self.timer = self.create_timer(0.1, self.battre)

    def scan(self, msg):
        limite = self.get_parameter("distance_min").get_parameter_value().double_value
        m = len(msg.ranges) // 2
        self.danger = any(msg.range_min < d < msg.range_max and d < limite for d in msg.ranges[m - 10 : m + 10])

    def battre(self):
        if self.danger:
            self.vitesses.publish(Twist())
