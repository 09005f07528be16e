"""Stops once two scans in a row agree, and goes on saying so for half a second."""
import math

from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class ArretUrgence(Node):
    def __init__(self):
        super().__init__("arret_confirme")
        self.declare_parameter("distance_min", 0.3)
        self.sortie = self.create_publisher(Twist, "cmd_vel", 1)
        self.create_subscription(LaserScan, "scan", self.sur_scan, 10)
        self.create_timer(0.1, self.sur_minuterie)
        self.de_suite, self.encore = 0, 0

    def sur_scan(self, scan):
        m = len(scan.ranges) // 2
        seuil = self.get_parameter("distance_min").value
        pres = False
        for d in scan.ranges[m - 10 : m + 10]:
            if math.isfinite(d) and scan.range_min < d < scan.range_max and d < seuil:
                pres = True
        self.de_suite = self.de_suite + 1 if pres else 0
        if self.de_suite >= 2:
            self.encore = 5

    def sur_minuterie(self):
        if self.encore > 0:
            self.encore -= 1
            self.sortie.publish(Twist())
