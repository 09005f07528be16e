import math

import rclpy
from geometry_msgs.msg import Twist, Vector3
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import LaserScan


class ArretUrgence(Node):
    def __init__(self, nom="securite"):
        super().__init__(nom)
        self.seuil = self.declare_parameter(
            "distance_min", 0.3, ParameterDescriptor(description="distance d'arrêt, en mètres")
        ).value
        self.add_on_set_parameters_callback(self.regler)
        qos = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=3, reliability=ReliabilityPolicy.BEST_EFFORT)
        self.create_subscription(LaserScan, "/scan", self.voir, qos)
        self.arret = self.create_publisher(Twist, "/cmd_vel", QoSProfile(depth=10))

    def regler(self, parametres):
        for p in parametres:
            if p.name == "distance_min":
                if p.type_ != Parameter.Type.DOUBLE or p.value <= 0.0 or math.isnan(p.value):
                    return SetParametersResult(successful=False, reason="une distance positive")
                self.seuil = p.value
        return SetParametersResult(successful=True)

    def voir(self, scan):
        milieu = len(scan.ranges) // 2
        for k in range(milieu - 10, milieu + 10):
            d = scan.ranges[k]
            if math.isfinite(d) and scan.range_min < d < scan.range_max and d < self.seuil:
                zero = Vector3(x=0.0, y=0.0, z=0.0)
                self.arret.publish(Twist(linear=zero, angular=zero))
                return


def main(args=None):
    rclpy.init(args=args)
    noeud = ArretUrgence()
    try:
        rclpy.spin(noeud)
    except KeyboardInterrupt:
        pass
    finally:
        noeud.destroy_node()
        rclpy.shutdown()


main()
