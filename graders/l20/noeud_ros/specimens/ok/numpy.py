import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class ArretUrgence(Node):
    """Avec np, que le module donne sans l'importer."""

    def __init__(self):
        super().__init__("frein_numpy")
        self.declare_parameters("", [("distance_min", 0.3), ("demi_fenetre", 10)])
        self.publieur = self.create_publisher(Twist, "cmd_vel", 1)
        self.abonnement = self.create_subscription(LaserScan, "scan", self.ecouter, 1)

    def ecouter(self, scan: LaserScan) -> None:
        seuil, demi = (p.value for p in self.get_parameters(["distance_min", "demi_fenetre"]))
        r = np.array(scan.ranges, dtype=np.float32)
        centre = r.size // 2
        r = r[centre - demi : centre + demi]
        with np.errstate(invalid="ignore"):
            danger = np.any((r > scan.range_min) & (r < min(scan.range_max, seuil)))
        if danger:
            self.publieur.publish(Twist())
