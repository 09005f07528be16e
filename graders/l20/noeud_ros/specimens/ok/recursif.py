import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


def danger(lectures, bas, haut, seuil):
    match list(lectures):
        case []:
            return False
        case [d, *reste]:
            return bas < d < haut and d < seuil or danger(reste, bas, haut, seuil)


class ArretUrgence(Node):
    def __init__(self):
        super().__init__("recursif")
        self.declare_parameter(name="distance_min", value=0.3)
        self.moteurs = self.create_publisher(Twist, "/cmd_vel", 10)
        self.etat = self.create_publisher(LaserScan, "~/devant", 10)
        self.create_subscription(LaserScan, "/scan", self.recevoir, 10)

    def recevoir(self, scan):
        n = len(scan.ranges) // 2
        scan.ranges = scan.ranges[n - 10 : n + 10]
        self.etat.publish(scan)
        if danger(scan.ranges, scan.range_min, scan.range_max, self.get_parameter("distance_min").value):
            self.moteurs.publish(Twist())
