import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class ArretUrgence(Node):
    def __init__(self):
        super().__init__("entier")
        self.declare_parameter("distance_min", 0.3)
        self.vitesses = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.recevoir, 10)

    def recevoir(self, scan):
        limite = self.get_parameter("distance_min").value
        milieu = len(scan.ranges) // 2
        lectures = scan.ranges[milieu - 10 : milieu + 10]
        if any(scan.range_min < d < min(limite, scan.range_max) for d in lectures):
            arret = Twist()
            arret.linear.x = 0
            self.vitesses.publish(arret)
