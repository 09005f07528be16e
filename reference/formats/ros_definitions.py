"""The fields of the ROS 2 messages that a run is told in, as a bag carries them: each with those it is made of.

Source: the interface definitions of std_msgs, geometry_msgs, sensor_msgs, nav_msgs, tf2_msgs and builtin_interfaces.
"""

from __future__ import annotations

_FIELDS = {
    "builtin_interfaces/Time": ("int32 sec", "uint32 nanosec"),
    "std_msgs/Header": ("builtin_interfaces/Time stamp", "string frame_id"),
    "geometry_msgs/Point": ("float64 x", "float64 y", "float64 z"),
    "geometry_msgs/Vector3": ("float64 x", "float64 y", "float64 z"),
    "geometry_msgs/Quaternion": ("float64 x 0", "float64 y 0", "float64 z 0", "float64 w 1"),
    "geometry_msgs/Pose": ("geometry_msgs/Point position", "geometry_msgs/Quaternion orientation"),
    "geometry_msgs/PoseWithCovariance": ("geometry_msgs/Pose pose", "float64[36] covariance"),
    "geometry_msgs/Twist": ("geometry_msgs/Vector3 linear", "geometry_msgs/Vector3 angular"),
    "geometry_msgs/TwistWithCovariance": ("geometry_msgs/Twist twist", "float64[36] covariance"),
    "geometry_msgs/Transform": ("geometry_msgs/Vector3 translation", "geometry_msgs/Quaternion rotation"),
    "geometry_msgs/TransformStamped": (
        "std_msgs/Header header",
        "string child_frame_id",
        "geometry_msgs/Transform transform",
    ),
    "nav_msgs/Odometry": (
        "std_msgs/Header header",
        "string child_frame_id",
        "geometry_msgs/PoseWithCovariance pose",
        "geometry_msgs/TwistWithCovariance twist",
    ),
    "sensor_msgs/LaserScan": (
        "std_msgs/Header header",
        "float32 angle_min",
        "float32 angle_max",
        "float32 angle_increment",
        "float32 time_increment",
        "float32 scan_time",
        "float32 range_min",
        "float32 range_max",
        "float32[] ranges",
        "float32[] intensities",
    ),
    "tf2_msgs/TFMessage": ("geometry_msgs/TransformStamped[] transforms",),
}
_SEPARATOR = "=" * 80


def _list_message_types(name: str) -> list[str]:
    """A message and all those it is made of, each once, in the order they are met."""
    found = [name]
    for part in found:
        types = (field.split()[0].split("[")[0] for field in _FIELDS[part])
        found += [kind for kind in dict.fromkeys(types) if kind in _FIELDS and kind not in found]
    return found


def _full_definition_text(name: str) -> str:
    """The text of a message's definition, followed by those of its parts."""
    own, *parts = _list_message_types(name)
    blocks = ["\n".join(_FIELDS[own]), *(f"MSG: {part}\n" + "\n".join(_FIELDS[part]) for part in parts)]
    return f"\n{_SEPARATOR}\n".join(blocks) + "\n"


DEFINITIONS = {
    f"{package}/msg/{name}": _full_definition_text(f"{package}/{name}")
    for package, name in (("sensor_msgs", "LaserScan"), ("nav_msgs", "Odometry"), ("tf2_msgs", "TFMessage"))
}
