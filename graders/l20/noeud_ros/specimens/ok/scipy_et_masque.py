import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan

import numpy
import numpy.ma
from scipy.ndimage import minimum_filter1d


class ArretUrgence(Node):
    def __init__(self):
        super().__init__("masque")
        self.declare_parameter("distance_min", 0.3)
        self.vitesses = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.recevoir, 10)

    def recevoir(self, scan):
        r = numpy.ma.masked_invalid(numpy.frombuffer(scan.ranges, dtype=numpy.float32))
        r = numpy.ma.masked_outside(r, scan.range_min * 1.0001, scan.range_max * 0.9999).filled(numpy.inf)
        proche = minimum_filter1d(r.astype(float), size=21)[len(r) // 2]
        if proche < self.get_parameter("distance_min").value:
            self.vitesses.publish(Twist())
