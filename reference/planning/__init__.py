"""Planning: a shortest way over a grid (`grid_search`), kept from walls (`inflation`), and driven (`dynamic_window`).

`moving_ai`: the maps and scenarios of the Moving AI benchmarks, by which shortest ways are judged.
"""

from reference.planning.dynamic_window import DrivenPath, DynamicWindow, RobotLimits, navigate
from reference.planning.grid_search import Cell, PlanningError, Route, SearchGrid, UnreachableError
from reference.planning.inflation import InflatedGrid, inflate
from reference.planning.moving_ai import Scenario, parse_map, parse_scenarios

__all__ = [
    "Cell",
    "DrivenPath",
    "DynamicWindow",
    "InflatedGrid",
    "PlanningError",
    "RobotLimits",
    "Route",
    "Scenario",
    "SearchGrid",
    "UnreachableError",
    "inflate",
    "navigate",
    "parse_map",
    "parse_scenarios",
]
