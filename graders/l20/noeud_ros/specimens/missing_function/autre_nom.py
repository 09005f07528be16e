import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class ArretDUrgence(Node):
    def __init__(self):
        super().__init__("arret")
