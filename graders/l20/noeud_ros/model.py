import math  # noqa: F401 (mistakes need it)

from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


def fenetre(msg, rayons, n):
    return rayons[n // 2 - 10 : n // 2 + 10]


def lectures(msg, devant):
    return [r for r in devant if msg.range_min < r < msg.range_max]


def trop_pres(msg, devant, valides, distance):
    return [r for r in valides if r < distance]


def reagir(noeud, proches, valides):
    if proches:
        noeud.moteurs.publish(Twist())


def declarer(noeud):
    noeud.declare_parameter("distance_min", 0.3)


def brancher(noeud):
    noeud.moteurs = noeud.create_publisher(Twist, "/cmd_vel", 10)
    noeud.create_subscription(LaserScan, "/scan", noeud.recevoir, 10)


def seuil(noeud):
    return noeud.get_parameter("distance_min").value


class ArretUrgence(Node):
    def __init__(self):
        super().__init__("frein")
        declarer(self)
        brancher(self)

    def recevoir(self, msg):
        rayons = list(msg.ranges)
        devant = fenetre(msg, rayons, len(rayons))
        valides = lectures(msg, devant)
        reagir(self, trop_pres(msg, devant, valides, seuil(self)), valides)
