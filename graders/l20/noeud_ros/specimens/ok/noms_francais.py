import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class ArretUrgence(Node):
    """Des noms à soi, que la bibliothèque aurait pu prendre."""

    def __init__(self):
        super().__init__("francais")
        self._avant, self._apres, self._nom, self._parametres = 10, 10, "frein", {}
        self._editeurs = [self.create_publisher(Twist, "/cmd_vel", 10)]
        self.declare_parameter("distance_min", 0.3)
        self._abonnements = self.create_subscription(LaserScan, "/scan", self._changer, 10)

    def _changer(self, message):
        milieu = len(message.ranges) // 2
        devant = message.ranges[milieu - self._avant : milieu + self._apres]
        while devant:
            if self._verifier(message, devant.pop()):
                self._editeurs[0].publish(Twist())
                devant = []

    def _verifier(self, message, lecture):
        if lecture <= message.range_min or lecture >= message.range_max:
            return False
        return lecture < self.get_parameter("distance_min").value
