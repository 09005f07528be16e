import rclpy
from rclpy.node import Node
from geometry_msgs.msg import Twist
from sensor_msgs.msg import LaserScan


class ArretUrgence(Node):
    def __init__(self):
        super().__init__("surveillant")
        self.declare_parameter("distance_min", 0.3)
        self.create_subscription(LaserScan, "/scan", self.regarder, 10)
        self.freins = self.create_publisher(Twist, "/cmd_vel", 10)

    def regarder(self, scan):
        centre = len(scan.ranges) // 2
        lus = [d for d in scan.ranges[centre - 10 : centre + 10] if scan.range_min < d < scan.range_max]
        if lus and min(lus) < self.get_parameter("distance_min").value:
            self.freins.publish(Twist())
            self.get_logger().warn(f"arrêt : {min(lus):.2f} m")


rclpy.init()
rclpy.spin(ArretUrgence())
