"""Places to simulate in, drawn from a seed: a building of rooms, a cluttered hall, a ring of corridors.

Each is a `GridMap` framed by walls, whose free cells are all connected by their sides. Sizes are in cells.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from reference.errors import InvalidArgumentError
from reference.world.grid_map import Grid, GridMap

Integers = NDArray[np.int64]

SMALLEST_ROOM = 8


class SceneError(InvalidArgumentError):
    """A place too small for what it should hold; `argument` names it."""


def random_building(
    rng: np.random.Generator, rooms: tuple[int, int], room: int = 20, door: int = 4, resolution: float = 0.05
) -> GridMap:
    """`rooms` = (rows, columns) of rooms about `room` cells wide, a door of `door` cells in each wall between two.

    The walls, one cell thick, are shifted by up to a sixth of a room; each room has a piece of furniture. Raises
    SceneError.
    """
    if min(rooms) < 1:
        raise SceneError("rooms", f"{rooms} is not a number of rows and columns")
    if room < max(SMALLEST_ROOM, 3 * door):
        raise SceneError("room", f"{room} cells are too few for a wall with a door of {door} cells")
    if door < 1:
        raise SceneError("door", f"{door} cells let nobody through")
    rows, columns = (_wall_positions(rng, count, room) for count in rooms)
    free = np.ones((rows[-1] + 1, columns[-1] + 1), dtype=np.bool_)
    free[rows], free[:, columns] = False, False
    for y, (left, right) in ((y, span) for y in rows[1:-1] for span in pairwise(columns)):
        free[y, _door_slice(rng, left, right, door)] = True
    for x, (top, bottom) in ((x, span) for x in columns[1:-1] for span in pairwise(rows)):
        free[_door_slice(rng, top, bottom, door), x] = True
    for top, bottom in pairwise(rows):
        for left, right in pairwise(columns):
            _add_box(rng, free[top + door : bottom - door + 1, left + door : right - door + 1])
    return GridMap.from_free(_largest_connected_part(free), resolution)


def random_clutter(
    rng: np.random.Generator, shape: tuple[int, int], obstacles: int, size: int = 6, resolution: float = 0.05
) -> GridMap:
    """A hall (H, W) with boxes of at most `size` cells a side scattered in it. Raises SceneError."""
    if min(shape) < 3:
        raise SceneError("shape", f"{shape} leaves no free cell within the walls")
    if obstacles < 0 or size < 1:
        raise SceneError("obstacles", f"{obstacles} boxes of {size} cells cannot be placed")
    free = np.ones(shape, dtype=np.bool_)
    for y, x in zip(*(rng.integers(0, length, obstacles) for length in shape), strict=True):
        height, width = rng.integers(1, size + 1, 2)
        free[y : y + height, x : x + width] = False
    free[[0, -1]], free[:, [0, -1]] = False, False
    if not free.any():
        raise SceneError("obstacles", f"{obstacles} boxes of {size} cells fill the hall")
    return GridMap.from_free(_largest_connected_part(free), resolution)


def random_ring(
    rng: np.random.Generator, shape: tuple[int, int], corridor: int = 12, niches: int = 24, resolution: float = 0.05
) -> GridMap:
    """A corridor that closes on itself around a block, (H, W) in all, with `niches` in its walls to tell places apart.

    Niches are at most half a corridor wide and deep; the corridor keeps its width. Raises SceneError.
    """
    depth = corridor // 2
    margin = depth + 1
    if corridor < 4 or min(shape) < 2 * (margin + corridor) + 2 * margin + 1:
        raise SceneError("shape", f"{shape} is too small for a ring of corridors of {corridor} cells")
    if niches < 0:
        raise SceneError("niches", f"{niches} niches cannot be dug")
    free = np.zeros(shape, dtype=np.bool_)
    height, width = shape
    free[margin : height - margin, margin : width - margin] = True
    inner = margin + corridor
    free[inner : height - inner, inner : width - inner] = False
    walls = np.argwhere(~free[1:-1, 1:-1] & _neighbours_of_free(free)[1:-1, 1:-1]) + 1
    for y, x in walls[rng.integers(0, len(walls), niches)]:
        tall, wide = rng.integers(1, depth + 1, 2)
        top, left = y - rng.integers(0, tall), x - rng.integers(0, wide)
        free[max(top, 1) : min(top + tall, height - 1), max(left, 1) : min(left + wide, width - 1)] = True
    return GridMap.from_free(_largest_connected_part(free), resolution)


def _wall_positions(rng: np.random.Generator, rooms: int, room: int) -> Integers:
    """Where the walls (rooms + 1,) stand along one axis."""
    lines = (room + 1) * np.arange(rooms + 1)
    lines[1:-1] += rng.integers(-(room // 6), room // 6 + 1, rooms - 1)
    return lines


def _door_slice(rng: np.random.Generator, start: int, end: int, door: int) -> slice:
    """Where a wall between two crossing ones, at `start` and `end`, opens."""
    first = int(rng.integers(start + 1, end - door + 1))
    return slice(first, first + door)


def _add_box(rng: np.random.Generator, inside: Grid) -> None:
    """Set one box in the inner part of a room, which leaves a passage all around."""
    height, width = inside.shape
    tall, wide = (int(rng.integers(1, max(2, length // 2))) for length in (height, width))
    y, x = int(rng.integers(0, max(1, height - tall))), int(rng.integers(0, max(1, width - wide)))
    inside[y : y + tall, x : x + wide] = False


def _neighbours_of_free(free: Grid) -> Grid:
    """The cells (H, W) that share a side with a free one."""
    beside = np.zeros_like(free)
    beside[1:] |= free[:-1]
    beside[:-1] |= free[1:]
    beside[:, 1:] |= free[:, :-1]
    beside[:, :-1] |= free[:, 1:]
    return beside


def _largest_connected_part(free: Grid) -> Grid:
    """The largest connected part of the free cells."""
    parts, _ = label(free)
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    return np.asarray(parts == np.argmax(sizes))
