import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class ArretUrgence(Node):
    def __init__(self):
        super().__init__("arret_urgence")
        self.pub = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.sur_scan, 10)
        self.declare_parameter("distance_min", 0.3)

    def sur_scan(self, msg):
        n = len(msg.ranges)
        devant = [r for r in msg.ranges[n // 2 - 10 : n // 2 + 10] if msg.range_min < r < msg.range_max]
        if devant and min(devant) < self.get_parameter("distance_min").value:
            self.pub.publish(Twist())
            self.get_logger().warn(f"obstacle à {min(devant):.2f} m : STOP")


rclpy.init()
rclpy.spin(ArretUrgence())
