import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class ArretUrgence(Node):
    """Arrête le robot quand un obstacle est trop près, devant."""

    def __init__(self):
        super().__init__("frein")
        # À vous : le paramètre distance_min, l'éditeur
        # de /cmd_vel, l'abonnement à /scan.

    def recevoir(self, scan):
        # À vous de jouer.
        pass


def main():
    rclpy.init()
    rclpy.spin(ArretUrgence())


if __name__ == "__main__":
    main()
