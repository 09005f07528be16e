"""Planning: a shortest way over a grid (`grid_search`), kept from walls (`inflation`), and driven (`dynamic_window`).

`moving_ai`: the maps and scenarios of the Moving AI benchmarks, by which shortest ways are judged.
"""

from reference.planning.dynamic_window import DynamicWindow, Journey, Limits, navigate
from reference.planning.grid_search import Cell, PlanningError, Route, SearchGrid, UnreachableError
from reference.planning.inflation import Inflated, inflate
from reference.planning.moving_ai import Scenario, parse_map, parse_scenarios

__all__ = [
    "Cell",
    "DynamicWindow",
    "Inflated",
    "Journey",
    "Limits",
    "PlanningError",
    "Route",
    "Scenario",
    "SearchGrid",
    "UnreachableError",
    "inflate",
    "navigate",
    "parse_map",
    "parse_scenarios",
]
