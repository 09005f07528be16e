import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class ArretUrgence(Node):
    """Relit le paramètre deux fois par seconde, et s'arrête s'il ne voit plus rien."""

    def __init__(self):
        super().__init__("veilleur")
        self.declare_parameter("distance_min", 0.3)
        self.relire()
        self.dernier = self.get_clock().now()
        self.create_timer(0.5, self.relire)
        self.create_timer(0.25, self.veiller)
        self.vitesses = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.recevoir, 10)

    def relire(self):
        self.distance = self.get_parameter("distance_min").value

    def veiller(self):
        if (self.get_clock().now() - self.dernier).nanoseconds > 0.3e9:
            self.vitesses.publish(Twist())

    def recevoir(self, scan):
        self.dernier = self.get_clock().now()
        n = len(scan.ranges)
        lectures = filter(lambda d: scan.range_min < d < scan.range_max, scan.ranges[n // 2 - 10 : n // 2 + 10])
        if min(lectures, default=float("inf")) < self.distance:
            self.vitesses.publish(Twist())
