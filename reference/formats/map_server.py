"""Maps as ROS keeps them: an occupancy grid of -1 and 0 … 100, and the pair of files of map_server (YAML and PGM).

Files are texts and bytes in memory. Row 0 of an image is its top row, row 0 of a map is its bottom row (least y): they
are flipped on the way. `origin` is the pose (x, y, yaw) of the image's lower left corner: `T_world_map` here.

Sources: nav_msgs/OccupancyGrid (ROS 2); map_server of the ROS wiki and nav2_map_server, "Map file format" and "Value
interpretation": a pixel p of 0 … m is a shade s = p / m, occupied with probability occ = 1 - s, or s if `negate`:

    trinary: 100 if occ > occupied_thresh, 0 if occ < free_thresh, else -1                                         (1)
    scale:   as above, but in between 100 (occ - free_thresh) / (occupied_thresh - free_thresh), rounded           (2)
    raw:     the pixel itself, 0 … 100, else -1; `negate` and thresholds do not count                              (3)
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from reference.errors import InvalidArgumentError, check_choice
from reference.formats.pgm import GreyImage, read_pgm, write_pgm
from reference.text import decode_lines
from reference.world.grid_map import GridMap

Floats = NDArray[np.float64]
Mode = Literal["trinary", "scale", "raw"]

MODES: dict[str, Mode] = {mode: mode for mode in get_args(Mode)}
UNKNOWN, FREE, OCCUPIED = -1, 0, 100
# What map_saver writes: its white, its grey, its black, and the thresholds that tell them apart.
WHITE, GREY, BLACK = 254, 205, 0
OCCUPIED_THRESH, FREE_THRESH = 0.65, 0.196

_ENTRY = re.compile(
    r"(?P<key>\w+)[ ]*:(?:[ ]+(?:\"(?P<double>[^\"\\]*)\"|'(?P<single>[^']*)'|(?P<list>\[[^\[\]#]*\])"
    r"|(?P<plain>[^\s\"'\[\]{}#&*!|>%@`,-]\S*?(?:[ ]+[^\s#]\S*)*?|-[0-9.]\S*?)))?(?:[ ]+\#.*)?[ ]*"
)
_ITEM = re.compile(r"[ ]*-[ ]+(?P<item>[^\s\"'\[\]{}#&*!|>%@`,]+)(?:[ ]+\#.*)?[ ]*")


class MapFileError(InvalidArgumentError):
    """Files that describe no map, or a map that files of that mode cannot hold; `argument` names the part at fault."""


@dataclass(frozen=True, eq=False)
class OccupancyGrid:
    """`values` (H, W): -1 unknown, else 0 (free) … 100 (occupied); `resolution` in metres a cell; `T_world_map` (3,).

    Raises MapFileError for other values; resolution and corner are checked as those of a `GridMap`.
    """

    values: NDArray[np.int8]
    resolution: float
    T_world_map: Floats

    def __post_init__(self) -> None:
        values = np.asarray(self.values)
        if values.ndim != 2 or values.size == 0 or np.any((values < -1) | (values > 100) | (values != np.rint(values))):
            raise MapFileError("values", f"of shape {values.shape} are not an array (H, W) of -1 and 0 … 100")
        object.__setattr__(self, "values", values.astype(np.int8))
        placed = GridMap(values == FREE, values == OCCUPIED, self.resolution, self.T_world_map)
        object.__setattr__(self, "T_world_map", placed.T_world_map)

    @classmethod
    def from_grid_map(cls, grid_map: GridMap) -> OccupancyGrid:
        """The grid of a map: 0 where free, 100 where occupied, -1 elsewhere."""
        values = np.where(grid_map.free, FREE, np.where(grid_map.occupied, OCCUPIED, UNKNOWN))
        return cls(values.astype(np.int8), grid_map.resolution, grid_map.T_world_map)

    def to_grid_map(self, free_below: int = 20, occupied_above: int = 64) -> GridMap:
        """The map whose cells are free below one value, and occupied above the other. Raises MapFileError."""
        if not 0 < free_below <= occupied_above < 100:
            raise MapFileError("free_below", f"{free_below} and {occupied_above} are not thresholds within 1 … 99")
        known = self.values >= 0
        free, occupied = known & (self.values < free_below), self.values > occupied_above
        return GridMap(free, occupied, self.resolution, self.T_world_map)


@dataclass(frozen=True)
class MapDescription:
    """What the YAML file says; `origin` is (x, y, yaw) in metres and radians. Raises MapFileError."""

    image: str
    resolution: float
    origin: tuple[float, float, float]
    negate: bool = False
    occupied_thresh: float = OCCUPIED_THRESH
    free_thresh: float = FREE_THRESH
    mode: Mode = "trinary"

    def __post_init__(self) -> None:
        if not self.image or not re.fullmatch(r"[^\"\\\x00-\x1f\x7f]+", self.image):
            raise MapFileError("image", f"{self.image!r} is not a name of a file")
        if not 0.0 < self.resolution < np.inf:
            raise MapFileError("resolution", f"{self.resolution} is not a positive length")
        if len(self.origin) != 3 or not np.all(np.isfinite(self.origin)):
            raise MapFileError("origin", f"{self.origin} is not (x, y, yaw)")
        check_choice("mode", self.mode, Mode, MapFileError)
        if not 0.0 <= self.free_thresh < self.occupied_thresh <= 1.0:
            raise MapFileError("free_thresh", f"{self.free_thresh} is not below occupied_thresh, in [0, 1]")


@dataclass(frozen=True)
class MapFiles:
    """The two files of a map: `yaml`, which names the image, and `pgm`."""

    yaml: str
    pgm: bytes


def read_description(yaml: str | bytes) -> MapDescription:
    """The description in a YAML file. Raises MapFileError, which names the entry at fault.

    Only the small part of YAML is read that these files use: one `key: value` a line, lists in brackets or as `- item`
    lines, comments. Anything else is refused with its line; entries of other names are left alone.
    """
    entries = _parse_yaml_entries(yaml)
    missing = [name for name in ("image", "resolution", "origin") if name not in entries]
    if missing:
        raise MapFileError(missing[0], "is not in the description")
    thresholds = {
        name: _parse_number(name, entries[name]) for name in ("occupied_thresh", "free_thresh") if name in entries
    }
    mode = entries.get("mode", "trinary").lower()
    if mode not in MODES:
        raise MapFileError("mode", f"{mode!r} is not trinary, scale or raw")
    return MapDescription(
        image=entries["image"],
        resolution=_parse_number("resolution", entries["resolution"]),
        origin=_parse_origin(entries["origin"]),
        negate=_parse_flag("negate", entries.get("negate", "0")),
        mode=MODES[mode],
        **thresholds,
    )


def write_description(description: MapDescription) -> str:
    """The YAML file of a description, as map_saver writes it."""
    entries = {
        "image": f'"{description.image}"',
        "mode": description.mode,
        "resolution": _format_decimal(description.resolution),
        "origin": "[" + ", ".join(map(_format_decimal, description.origin)) + "]",
        "negate": int(description.negate),
        "occupied_thresh": _format_decimal(description.occupied_thresh),
        "free_thresh": _format_decimal(description.free_thresh),
    }
    return "".join(f"{name}: {value}\n" for name, value in entries.items())


def read_map(yaml: str | bytes, pgm: bytes) -> OccupancyGrid:
    """The occupancy grid of a description and its image, by (1), (2) or (3). Raises MapFileError, and PgmError."""
    description, image = read_description(yaml), read_pgm(pgm)
    values = _grey_to_occupancy(description, image)[::-1]
    return OccupancyGrid(values, description.resolution, np.array(description.origin))


def write_map(grid: OccupancyGrid, image: str = "map.pgm", mode: Mode = "trinary") -> MapFiles:
    """The files of a grid, which `read_map` brings back as it was. Raises MapFileError for a grid that would not.

    Trinary files hold -1, 0 and 100 only; those of scale no -1, for which the format would want transparency.
    """
    x, y, yaw = grid.T_world_map.tolist()
    description = MapDescription(image, grid.resolution, (x, y, yaw), mode=mode)
    pixels = _occupancy_to_grey(grid.values, mode)[::-1]
    return MapFiles(write_description(description), write_pgm(GreyImage(pixels)))


def _grey_to_occupancy(description: MapDescription, image: GreyImage) -> NDArray[np.int8]:
    if description.mode == "raw":
        raw = np.rint(image.pixels * (255.0 / image.max_value))
        return np.where(raw <= OCCUPIED, raw, UNKNOWN).astype(np.int8)
    shade = image.pixels / image.max_value
    occ = shade if description.negate else 1.0 - shade
    low, high = description.free_thresh, description.occupied_thresh
    between = np.rint(100.0 * (occ - low) / (high - low)) if description.mode == "scale" else np.full_like(occ, UNKNOWN)
    return np.select([occ > high, occ < low], [OCCUPIED, FREE], between).astype(np.int8)


def _occupancy_to_grey(values: NDArray[np.int8], mode: Mode) -> NDArray[np.int64]:
    wide = values.astype(np.int64)
    if mode == "raw":
        return np.where(wide == UNKNOWN, 255, wide)
    if mode == "scale":
        if np.any(wide == UNKNOWN):
            raise MapFileError("values", "hold unknown cells, which a grey image in mode scale cannot show")
        occ = FREE_THRESH + wide / 100.0 * (OCCUPIED_THRESH - FREE_THRESH)
        return np.select(
            [wide == FREE, wide == OCCUPIED], [WHITE, BLACK], np.rint(255.0 * (1.0 - occ)).astype(np.int64)
        )
    if not np.all(np.isin(wide, (UNKNOWN, FREE, OCCUPIED))):
        raise MapFileError("values", "hold others than -1, 0 and 100, which mode trinary cannot tell")
    return np.select([wide == FREE, wide == OCCUPIED], [WHITE, BLACK], GREY)


def _parse_yaml_entries(yaml: str | bytes) -> dict[str, str]:
    """The values as they are written, quotes apart; a list of `- item` lines as one in brackets."""
    found: dict[str, str] = {}
    listed: dict[str, list[str]] = {}
    key = ""
    for number, written_line in enumerate(decode_lines(yaml, "yaml", MapFileError), start=1):
        line = written_line.expandtabs()
        if not line.strip() or line.lstrip().startswith("#") or line.rstrip() == "---":
            continue
        item = _ITEM.fullmatch(line)
        if item and key in listed:
            listed[key].append(item["item"])
            continue
        entry = _ENTRY.fullmatch(line)
        if entry is None or ": " in (entry["plain"] or ""):
            raise MapFileError("yaml", f"line {number} is not a `key: value` of those that are read here")
        key = entry["key"]
        if key in found:
            raise MapFileError(key, f"is given a second time, on line {number}")
        written = [entry[kind] for kind in ("double", "single", "list", "plain") if entry[kind] is not None]
        found[key] = written[0] if written else ""
        if not written:
            listed[key] = []
    return found | {name: f"[{', '.join(items)}]" for name, items in listed.items()}


def _parse_number(name: str, written: str) -> float:
    try:
        return float(written)
    except ValueError:
        raise MapFileError(name, f"{written!r} is not a number") from None


def _parse_origin(written: str) -> tuple[float, float, float]:
    parts = written[1:-1].split(",") if written.startswith("[") else []
    if len(parts) != 3:
        raise MapFileError("origin", f"{written!r} is not a list [x, y, yaw]")
    x, y, yaw = (_parse_number("origin", part) for part in parts)
    return x, y, yaw


def _parse_flag(name: str, written: str) -> bool:
    flags = {"0": False, "false": False, "1": True, "true": True}
    if written.lower() not in flags:
        raise MapFileError(name, f"{written!r} is not 0 or 1")
    return flags[written.lower()]


def _format_decimal(value: float) -> str:
    """All the digits of a number, with the point that YAML wants before an exponent."""
    text = repr(float(value))
    return text if "e" not in text or "." in text else text.replace("e", ".0e")
