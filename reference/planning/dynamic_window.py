"""Driving to a goal with the dynamic window: try the speeds within reach, keep the safe ones, take the best.

A speed (v, w), in m/s and rad/s, is kept for one period. It is safe if the robot, having driven it for one period, can
then brake to a stand without touching anything. Braking is always among the choices, and follows the very way that was
found safe a period earlier: so a robot that starts at rest never collides, whatever the map.

The best speed leads down the cost of the way that remains (Dijkstra from the goal over inflated walls), measured at the
robot and a little ahead of it, so that turning towards the way counts too. Over one horizon this may be lowest where
the robot stands: it faces away from the goal, and no turn within reach is worth its while. So a robot whose cost has
not fallen for `patience` seconds is led: it brakes, turns on the spot towards the next cell of the cheapest way, and
drives straight there, cell after cell, until the cost has fallen below its least by `PROGRESS` of a cell.

From rest, it thereby reaches every goal to which a way of cells leads. A turn on the spot touches nothing; the straight
line from a point of a cell to the centre of the next one stays within free cells, since ways cut no corner; and each
cell costs less than the one before. The least cost so far falls by a fixed amount each time that the robot is led, and
never below zero.

Sources: Fox, Burgard, Thrun, "The Dynamic Window Approach to Collision Avoidance" (1997); Brock and Khatib, "High-speed
Navigation Using the Global Dynamic Window Approach" (1999), for the cost to go and for its stalls.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import distance_transform_edt, map_coordinates

from reference.planning.grid_search import MOVES, PlanningError, SearchGrid
from reference.planning.inflation import inflate
from reference.se2 import wrap_angle
from reference.world.grid_map import GridMap

Floats = NDArray[np.float64]

PARTS = 4
# A fall of the cost by this share of a cell's side is progress.
PROGRESS = 0.25
# An angle (rad) or a length (m) that no robot tells from none.
NEGLIGIBLE = 1e-9
SQRT2 = float(np.sqrt(2.0))


@dataclass(frozen=True)
class RobotLimits:
    """A round differential robot: `radius` (m), speeds (m/s, rad/s), accelerations (m/s^2, rad/s^2); never backwards.

    It decides once a `period` (s), looks `horizon` (s) ahead, and tries `samples` values of v and of w. It is led after
    `patience` (s) without progress.
    """

    radius: float = 0.2
    max_v: float = 0.6
    max_w: float = 1.8
    max_dv: float = 0.8
    max_dw: float = 4.0
    period: float = 0.1
    horizon: float = 1.0
    samples: int = 11
    patience: float = 1.0

    def __post_init__(self) -> None:
        for name in ("radius", "max_v", "max_w", "max_dv", "max_dw", "period", "horizon", "patience"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise PlanningError(name, f"{getattr(self, name)} is not a positive number")
        if self.samples < 2:
            raise PlanningError("samples", "fewer than 2 leave no choice")


@dataclass(frozen=True, eq=False)
class DrivenPath:
    """`poses` (k + 1, 3), one a period, the `speeds` (k, 2) = (v, w) between them, and whether the goal was reached.

    `clearance`: how near, in metres, the robot's rim came to a wall at least, counted safely.
    """

    poses: Floats
    speeds: Floats
    has_reached_goal: bool
    clearance: float


@dataclass(frozen=True, eq=False)
class DynamicWindow:
    """A robot with a map and a goal: `clear` (H, W), metres to walls, at least; `remaining` (H, W), costs to go.

    `ways` (H, W) are the same costs, infinite where the robot cannot stand, or from where no way leads.
    """

    world: GridMap
    goal: Floats
    limits: RobotLimits
    clear: Floats = field(repr=False)
    remaining: Floats = field(repr=False)
    ways: Floats = field(repr=False)

    @classmethod
    def from_goal(cls, world: GridMap, goal: ArrayLike, limits: RobotLimits) -> DynamicWindow:
        """For a goal (2,) in the world. What is not known free is taken for wall. Raises PlanningError."""
        point = np.asarray(goal, dtype=np.float64)
        if point.shape != (2,) or not np.all(np.isfinite(point)):
            raise PlanningError("goal", "is not a point (2,) of finite numbers")
        # From any point of a cell to any point of a wall's: half a diagonal less at both ends.
        cells = distance_transform_edt(np.pad(world.free, 1))[1:-1, 1:-1]
        clear = world.resolution * np.maximum(np.asarray(cells) - SQRT2, 0.0)
        inflated = inflate(world.free, limits.radius / world.resolution + SQRT2)
        x, y = np.floor(world.to_cells(point)).astype(np.int64).tolist()
        height, width = world.shape
        if not (0 <= y < height and 0 <= x < width and inflated.free[y, x]):
            raise PlanningError("goal", "is not a place where the robot can stand")
        remaining = SearchGrid(inflated.free, inflated.costs).costs_from((y, x)) * world.resolution
        return cls(world, point, limits, clear, _replace_infinite_costs(remaining, world.resolution), remaining)

    def choose_speed(self, pose: Floats, speed: Floats) -> Floats:
        """The speed (2,) = (v, w) for the next period, from the pose (3,) and speed so far."""
        limits = self.limits
        choices = self._reachable_speeds(speed)
        stops = predict_drive(pose, choices, limits, brake=True, duration=limits.period)
        safe = self.clearance(stops).min(axis=1) > limits.radius
        safe[0] = True  # braking: found safe a period ago, as a part of that choice
        choices = choices[safe]
        ahead = predict_drive(pose, choices, limits, brake=False, duration=limits.horizon)
        ends = ahead[:, -1]
        reach = np.minimum(2.0 * limits.radius, np.linalg.norm(ends[:, :2] - self.goal, axis=1))
        nose = ends[:, :2] + reach[:, None] * np.column_stack([np.cos(ends[:, 2]), np.sin(ends[:, 2])])
        room = np.minimum(self.clearance(ahead).min(axis=1), 2.0 * limits.radius)
        cost = self._costs_to_go(ends[:, :2]) + self._costs_to_go(nose) - room
        return np.asarray(choices[int(np.argmin(cost))])

    def follow_route(self, pose: Floats, speed: Floats) -> Floats:
        """The speed (2,) that leads from the pose (3,) to the next cell of the cheapest way: brake, turn, go straight.

        Braking where no way leads.
        """
        limits, target = self.limits, self._cheapest_neighbour_point(pose)
        slower = brake_speeds(speed[None], limits)[0]
        if target is None:
            return np.asarray(slower)
        ahead = target - pose[:2]
        distance = float(np.hypot(*ahead))
        turn = wrap_angle(float(np.arctan2(ahead[1], ahead[0]) - pose[2])) if distance > NEGLIGIBLE else 0.0
        if abs(turn) > NEGLIGIBLE:
            if speed[0] > 0.0:
                return np.asarray(slower)
            step = limits.max_dw * limits.period
            return np.array([0.0, _greatest_stoppable_speed(turn, speed[1], step, limits.max_w, limits.period)])
        if speed[1] != 0.0:
            return np.asarray(slower)
        step = limits.max_dv * limits.period
        forward = np.array([_greatest_stoppable_speed(distance, speed[0], step, limits.max_v, limits.period), 0.0])
        stops = predict_drive(pose, forward[None], limits, brake=True, duration=limits.period)
        return forward if self.clearance(stops).min() > limits.radius else np.asarray(slower)

    def cost_to_go(self, point: ArrayLike) -> float:
        """The cost of the way from a point (2,) of the world to the goal, drawn between the centres of cells."""
        return float(self._costs_to_go(np.asarray(point, dtype=np.float64)[None])[0])

    def _cheapest_neighbour_point(self, pose: Floats) -> Floats | None:
        """Return the next point (2,) of the cheapest way: a centre of a cell, or the goal; None for no way."""
        x, y = np.floor(self.world.to_cells(pose[:2])).astype(np.int64).tolist()
        height, width = self.ways.shape

        def cost(cell_y: int, cell_x: int) -> float:
            return float(self.ways[cell_y, cell_x]) if 0 <= cell_y < height and 0 <= cell_x < width else np.inf

        if not np.isfinite(cost(y, x)):
            return None
        if cost(y, x) == 0.0:
            return self.goal
        sides_free = ((dy, dx) for dy, dx in MOVES if np.isfinite(cost(y + dy, x)) and np.isfinite(cost(y, x + dx)))
        dy, dx = min(sides_free, key=lambda move: cost(y + move[0], x + move[1]))
        return np.asarray(self.world.to_world(np.array([x + dx + 0.5, y + dy + 0.5])))

    def clearance(self, poses: Floats) -> Floats:
        """Metres to the nearest wall, counted safely, for poses (…, 3); 0 off the map."""
        cells = np.floor(self.world.to_cells(poses[..., :2])).astype(np.int64)
        x, y = cells[..., 0], cells[..., 1]
        inside = (x >= 0) & (x < self.clear.shape[1]) & (y >= 0) & (y < self.clear.shape[0])
        return np.where(inside, self.clear[np.where(inside, y, 0), np.where(inside, x, 0)], 0.0)

    def _reachable_speeds(self, speed: Floats) -> Floats:
        """The speeds (k, 2) within reach in one period; braking as hard as can be comes first."""
        limits = self.limits
        dv, dw = limits.max_dv * limits.period, limits.max_dw * limits.period
        v = np.linspace(max(0.0, speed[0] - dv), min(limits.max_v, speed[0] + dv), limits.samples)
        w = np.linspace(max(-limits.max_w, speed[1] - dw), min(limits.max_w, speed[1] + dw), limits.samples)
        grid = np.stack(np.meshgrid(v, np.append(w, 0.0) if abs(speed[1]) <= dw else w), axis=-1).reshape(-1, 2)
        return np.vstack([brake_speeds(speed[None], limits), grid])

    def _costs_to_go(self, points: Floats) -> Floats:
        x, y = (self.world.to_cells(points) - 0.5).T
        return np.asarray(map_coordinates(self.remaining, [y, x], order=1, mode="nearest"))


def _greatest_stoppable_speed(way: float, speed: float, step: float, most: float, period: float) -> float:
    """The greatest speed after one period from which one can still stop within `way`, a length or an angle.

    Speeds change by `step` a period at most; on the other side, or where none can stop in time, it is the slowest.
    """
    low, high = max(-most, speed - step), min(most, speed + step)
    if way < 0.0:
        return -_greatest_stoppable_speed(-way, -speed, step, most, period)
    exact = way / period
    if exact <= step and low <= exact <= high:
        return exact
    # Kept for one period, then lowered by a step a period: v (n + 1) - step n (n + 1) / 2 periods, n = floor(v / step).
    for candidate in np.linspace(high, low, 21).tolist():
        n = np.floor(max(candidate, 0.0) / step)
        if candidate * (n + 1.0) - step * n * (n + 1.0) / 2.0 <= exact:
            return float(candidate)
    return float(low)


def brake_speeds(speeds: Floats, limits: RobotLimits) -> Floats:
    """Speeds (k, 2) after one period of braking."""
    less = np.array([limits.max_dv, limits.max_dw]) * limits.period
    return np.asarray(np.sign(speeds) * np.maximum(np.abs(speeds) - less, 0.0))


def predict_drive(pose: Floats, speeds: Floats, limits: RobotLimits, *, brake: bool, duration: float) -> Floats:
    """Poses (k, m, 3) passed from `pose` (3,) at the speeds (k, 2), each kept for `duration`, then braked if asked."""
    periods = max(1, round(duration / limits.period))
    if brake:
        stop = max(np.abs(speeds[:, 0]).max() / limits.max_dv, np.abs(speeds[:, 1]).max() / limits.max_dw)
        periods += int(np.ceil(stop / limits.period)) + 1
    current = np.tile(pose, (len(speeds), 1))
    passed = [current]
    for number in range(periods):
        if number and brake:
            speeds = brake_speeds(speeds, limits)
        for _ in range(PARTS):
            current = move_along_arcs(current, speeds, limits.period / PARTS)
            passed.append(current)
    return np.stack(passed, axis=1)


def move_along_arcs(poses: Floats, speeds: Floats, duration: float) -> Floats:
    """Poses (k, 3) after `duration` at the speeds (k, 2): exact along the arc of a circle.

    The chord of an arc of length s and turn a is s sin(a/2) / (a/2), at half the turn.
    """
    way, turn = speeds[:, 0] * duration, speeds[:, 1] * duration
    chord, middle = way * np.sinc(turn / (2.0 * np.pi)), poses[:, 2] + turn / 2.0
    steps = np.column_stack([chord * np.cos(middle), chord * np.sin(middle), turn])
    moved = poses + steps
    moved[:, 2] = wrap_angle(moved[:, 2])
    return moved


def _replace_infinite_costs(costs: Floats, resolution: float) -> Floats:
    """Costs with their infinities replaced: by that of the nearest finite cell, and more the farther it is."""
    closed = ~np.isfinite(costs)
    away, (y, x) = distance_transform_edt(closed, return_indices=True)
    return np.asarray(costs[y, x] + 20.0 * resolution * away)


def navigate(
    world: GridMap,
    start: ArrayLike,
    goal: ArrayLike,
    limits: RobotLimits | None = None,
    *,
    tolerance: float = 0.15,
    max_time: float = 120.0,
) -> DrivenPath:
    """Drive from rest at the pose `start` (3,) to within `tolerance` (m) of `goal` (2,), or for `max_time` seconds.

    The speeds are those of `choose_speed`, and of `follow_route` once they bring no progress. A goal to which no way
    leads is not reached. Raises PlanningError when the robot cannot stand at either end.
    """
    bounds = limits or RobotLimits()
    window = DynamicWindow.from_goal(world, goal, bounds)
    pose, speed = np.array(start, dtype=np.float64), np.zeros(2)
    if pose.shape != (3,) or not np.all(np.isfinite(pose)) or window.clearance(pose) <= bounds.radius:
        raise PlanningError("start", "is not a pose (3,) at which the robot can stand")
    poses, nearest, reached = [pose], float(window.clearance(pose)), False
    speeds: list[Floats] = []
    least, since = np.inf, 0.0
    while not reached and len(speeds) * bounds.period < max_time:
        cost = window.cost_to_go(pose[:2])
        if cost < least - PROGRESS * world.resolution:
            least, since = cost, 0.0
        speed = window.choose_speed(pose, speed) if since < bounds.patience else window.follow_route(pose, speed)
        since += bounds.period
        passed = predict_drive(pose, speed[None], bounds, brake=False, duration=bounds.period)[0]
        pose, nearest = passed[-1], min(nearest, float(window.clearance(passed).min()))
        poses.append(pose)
        speeds.append(speed)
        reached = bool(np.hypot(*(pose[:2] - np.asarray(goal))) <= tolerance)
    return DrivenPath(np.array(poses), np.array(speeds).reshape(-1, 2), reached, nearest - bounds.radius)
