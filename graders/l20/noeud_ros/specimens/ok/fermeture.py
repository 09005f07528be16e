import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class ArretUrgence(Node):
    def __init__(self):
        super().__init__("fermetures")
        self.declare_parameter("distance_min", 0.3)
        editeur = self.create_publisher(Twist, "/cmd_vel", 10)

        def proche(scan, d):
            return scan.range_min < d < min(scan.range_max, self.get_parameter("distance_min").value)

        def reagir(scan):
            n = len(scan.ranges)
            if True in (proche(scan, scan.ranges[k]) for k in range(n // 2 - 10, n // 2 + 11)):
                editeur.publish(Twist())

        self.create_subscription(LaserScan, "/scan", lambda scan: reagir(scan), 10)
