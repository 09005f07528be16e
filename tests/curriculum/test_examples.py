"""The calls that an exercise offers to begin from: read as they would be typed, and answered by its solution."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from server.course import Exercise
