import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


class ArretUrgence(Node):
    """Publie une vitesse nulle quand un obstacle est trop près, devant."""

    def __init__(self):
        super().__init__("frein")
        # Un paramètre, et non une constante : « ros2 param set » le change sans arrêter le robot.
        self.declare_parameter("distance_min", 0.3)
        self.moteurs = self.create_publisher(Twist, "/cmd_vel", 10)
        # On donne la fonction elle-même, sans parenthèses : c'est ROS qui l'appellera, à chaque scan.
        self.create_subscription(LaserScan, "/scan", self.recevoir, qos_profile_sensor_data)

    def recevoir(self, scan):
        # Relu à chaque scan : la valeur est celle de maintenant.
        distance_min = self.get_parameter("distance_min").value
        # Le milieu dépend du nombre de rayons, que chaque lidar choisit.
        milieu = len(scan.ranges) // 2
        devant = scan.ranges[milieu - 10 : milieu + 10]
        # nan et +inf ne passent pas cet encadrement, ni ce qui est au-delà de la portée.
        valides = [d for d in devant if scan.range_min < d < scan.range_max]
        # any, et non min : la liste des lectures valides peut être vide.
        if any(d < distance_min for d in valides):
            self.moteurs.publish(Twist())  # un Twist neuf ne contient que des zéros


def main():
    rclpy.init()
    try:
        rclpy.spin(ArretUrgence())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # Ctrl-C : une fin ordinaire
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
