import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class ArretUrgence(Node):
    """Ne publie qu'au moment où l'obstacle apparaît."""

    def __init__(self):
        super().__init__("arret_urgence")
        self.declare_parameter("distance_min", 0.3)
        self.moteurs = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.recevoir, 10)
        self.arrete = False

    def recevoir(self, scan):
        milieu = len(scan.ranges) // 2
        devant = list(scan.ranges)[milieu - 10 : milieu + 10]
        danger = False
        for d in devant:
            if d > scan.range_min:
                if d < scan.range_max:
                    if d < self.get_parameter("distance_min").value:
                        danger = True
        if danger and not self.arrete:
            self.get_logger().error("obstacle !", once=True)
            self.moteurs.publish(Twist())
        self.arrete = danger
