import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class ArretUrgence(Node):
    def __init__(self):
        self.vitesses = self.create_publisher(Twist, "/cmd_vel", 10)
