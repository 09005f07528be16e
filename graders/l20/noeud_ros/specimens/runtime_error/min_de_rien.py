import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class ArretUrgence(Node):
    def __init__(self):
        super().__init__("min_de_rien")
        self.declare_parameter("distance_min", 0.3)
        self.vitesses = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.recevoir, 10)

    def recevoir(self, scan):
        milieu = len(scan.ranges) // 2
        lectures = scan.ranges[milieu - 10 : milieu + 10]
        plus_proche = min(d for d in lectures if scan.range_min < d < scan.range_max)
        limite = self.get_parameter("distance_min").value
        if plus_proche < limite:
            self.vitesses.publish(Twist())
