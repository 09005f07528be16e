import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class ArretUrgence(Node):
    def __init__(self):
        super().__init__("boucle")
        self.create_subscription(LaserScan, "/scan", self.recevoir, 10)

    def recevoir(self, scan):
        while True:
            pass
