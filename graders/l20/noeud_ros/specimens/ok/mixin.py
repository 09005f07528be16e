from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


class Devant:
    LARGEUR = 20

    def devant(self, scan):
        debut = (len(scan.ranges) - self.LARGEUR) // 2
        return scan.ranges[debut : debut + self.LARGEUR]

    @staticmethod
    def valide(scan, d):
        return d == d and d != float("inf") and scan.range_min < d < scan.range_max


class Base(Node):
    def __init__(self, nom, **options):
        super().__init__(nom, **options)
        self.declare_parameter("distance_min", 0.3)


class ArretUrgence(Devant, Base):
    def __init__(self):
        super().__init__("arret_herite")
        self.create_subscription(LaserScan, "/scan", self.recevoir, qos_profile_sensor_data)
        self.__sortie = self.create_publisher(Twist, "/cmd_vel", qos_profile_sensor_data)

    def recevoir(self, scan):
        distances = sorted(d for d in self.devant(scan) if self.valide(scan, d))
        if distances and distances[0] < self.get_parameter("distance_min").value:
            arret = Twist()
            arret.linear.x = arret.linear.y = arret.linear.z = 0.0
            arret.angular.z = 0.0
            self.__sortie.publish(arret)
