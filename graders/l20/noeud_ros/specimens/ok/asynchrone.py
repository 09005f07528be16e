import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class ArretUrgence(Node):
    def __init__(self):
        super().__init__("asynchrone")
        self.declare_parameter("distance_min", 0.3)
        self.vitesses = self.create_publisher(msg_type=Twist, topic="/cmd_vel", qos_profile=10)
        self.create_subscription(msg_type=LaserScan, topic="/scan", callback=self.recevoir, qos_profile=10)

    async def recevoir(self, msg):
        if await self.danger(msg):
            self.vitesses.publish(Twist())

    async def danger(self, msg):
        n = len(msg.ranges)
        seuil = self.get_parameter_or("distance_min").value
        return not all(
            not (msg.range_min < r < msg.range_max) or r >= seuil for r in msg.ranges[n // 2 - 10 : n // 2 + 10]
        )


def main():
    rclpy.init()
    noeud = ArretUrgence()
    while rclpy.ok():
        rclpy.spin_once(noeud, timeout_sec=0.1)
    noeud.destroy_node()
    rclpy.try_shutdown()


main()
