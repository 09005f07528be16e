import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan

import math
from array import array


class ArretUrgence(Node):
    seuil = 0.3

    def __init__(self):
        Node.__init__(self, "apres")
        self.add_post_set_parameters_callback(self.change)
        self.declare_parameter("distance_min", self.seuil)
        self.vitesses = self.create_publisher(Twist, "//cmd_vel"[1:], 10)
        self.create_subscription(LaserScan, "/scan", self.recevoir, 10)

    def change(self, parametres):
        for p in parametres:
            setattr(self, {"distance_min": "seuil"}.get(p.name, p.name), p.value)

    def recevoir(self, scan):
        milieu = len(scan.ranges) / 2
        devant = array("d", (d for k, d in enumerate(scan.ranges) if abs(k + 0.5 - milieu) <= 10))
        plus_proche = math.inf
        for d in devant:
            if scan.range_min < d < scan.range_max:
                plus_proche = min(plus_proche, d)
        if plus_proche < self.seuil:
            self.vitesses.publish(Twist())
