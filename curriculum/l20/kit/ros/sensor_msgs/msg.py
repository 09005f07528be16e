"""Ce que publient les capteurs."""

from champs import FLOAT, UINT8, Message, Tableau
from std_msgs.msg import Header


class LaserScan(Message):
    """Un tour de lidar. `ranges` : les distances en mètres, du rayon d'angle `angle_min` au dernier."""

    champs = {
        "header": Header,
        "angle_min": FLOAT,
        "angle_max": FLOAT,
        "angle_increment": FLOAT,
        "time_increment": FLOAT,
        "scan_time": FLOAT,
        "range_min": FLOAT,
        "range_max": FLOAT,
        "ranges": Tableau("f", "float"),
        "intensities": Tableau("f", "float"),
    }


class Range(Message):
    """Une seule distance, d'un télémètre à ultrasons (0) ou à infrarouge (1)."""

    ULTRASOUND, INFRARED = 0, 1
    champs = {
        "header": Header,
        "radiation_type": UINT8,
        "field_of_view": FLOAT,
        "min_range": FLOAT,
        "max_range": FLOAT,
        "range": FLOAT,
    }
