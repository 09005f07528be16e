import sys

import rclpy
import rclpy.executors
from geometry_msgs.msg import Twist
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.qos import DurabilityPolicy, QoSPresetProfiles, QoSProfile
from sensor_msgs.msg import LaserScan


class ArretUrgence(rclpy.node.Node):
    def __init__(self):
        super(ArretUrgence, self).__init__("executeur", namespace="/")
        self.declare_parameter("distance_min", rclpy.Parameter.Type.DOUBLE)
        if self.get_parameter_or("distance_min", None).value is None:
            self.set_parameters([rclpy.Parameter("distance_min", rclpy.Parameter.Type.DOUBLE, 0.3)])
        groupe = ReentrantCallbackGroup()
        self.sub = self.create_subscription(
            LaserScan, "/scan", self.cb, QoSPresetProfiles.SENSOR_DATA.value, callback_group=groupe
        )
        tenace = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.vitesses = self.create_publisher(Twist, "/cmd_vel", tenace)

    def cb(self, m):
        r, n = m.ranges.tolist(), len(m.ranges)
        proches = {x for x in r[n // 2 - 10 : n // 2 + 10] if m.range_min < x < m.range_max}
        if proches and min(proches) < self.get_parameter("distance_min").value:
            self.vitesses.publish(Twist())


if rclpy.ok():
    sys.exit("déjà en marche")
with rclpy.Context() as _:
    pass
rclpy.init()
executeur = rclpy.executors.MultiThreadedExecutor(num_threads=2)
executeur.add_node(ArretUrgence())
try:
    executeur.spin()
except rclpy.executors.ExternalShutdownException:
    pass
finally:
    executeur.shutdown()
    rclpy.shutdown()
