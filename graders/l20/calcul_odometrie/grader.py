"""l20/calcul_odometrie: one step of odometry by hand, and how its error grows."""

from __future__ import annotations

import math

import numpy as np

from graders.core.answers.numeric import numeric
from graders.core.answers.quantity import Data, Quantity, Values
from reference.odometry import DifferentialDrive, LateralDrift

MILLI = 1e-3


def deal(rng: np.random.Generator) -> Data:
    """A robot that turns by a visible angle, and a start that is not along an axis."""
    return {
        "L": int(rng.integers(20, 46)) / 100,
        "dsg": int(rng.integers(80, 160)) / 1000,
        "dsd": int(rng.integers(80, 160)) / 1000,
        "x0": int(rng.integers(5, 40)) / 10,
        "y0": int(rng.integers(5, 40)) / 10,
        "theta0": int(rng.integers(4, 14)) / 10,
        "sigma": int(rng.integers(5, 25)) / 10,
        "n": int(rng.integers(4, 31)) * 100,
    }


def drive(data: Data) -> DifferentialDrive:
    return DifferentialDrive(track=data["L"], sigma=data["sigma"] * MILLI)


def ds(data: Data, _: Values) -> float:
    return drive(data).motion_from_wheels(data["dsg"], data["dsd"]).distance


def dtheta(data: Data, _: Values) -> float:
    return drive(data).motion_from_wheels(data["dsg"], data["dsd"]).turn


def middle(data: Data, earlier: Values) -> float:
    """The heading in the middle of the step."""
    return data["theta0"] + earlier["dtheta"] / 2


def x(data: Data, earlier: Values) -> float:
    return data["x0"] + earlier["ds"] * math.cos(middle(data, earlier))


def y(data: Data, earlier: Values) -> float:
    return data["y0"] + earlier["ds"] * math.sin(middle(data, earlier))


def theta(data: Data, earlier: Values) -> float:
    return data["theta0"] + earlier["dtheta"]


def sigma_dtheta(data: Data, _: Values) -> float:
    return 1000 * drive(data).turn_deviation(data["dsg"], data["dsd"])


def sigma_theta(data: Data, earlier: Values) -> float:
    return LateralDrift(int(data["n"]), 0.0, abs(earlier["sigma_dtheta"]) * MILLI).heading_deviation


def drift(data: Data, earlier: Values) -> float:
    """The heading is wrong by sigma_theta from the first step on."""
    return data["n"] * earlier["ds"] * earlier["sigma_theta"]


def deviation(data: Data, earlier: Values) -> float:
    """What the course says of the drift when the heading errs little by little: right, but not what is asked."""
    return drift(data, earlier) / math.sqrt(3)


REL, ABS = 0.004, 0.0004  # four significant digits, and what rounding to them leaves
QUANTITIES = (
    Quantity("ds", 2, ds, rel=REL, slips={"somme_au_lieu_de_moyenne": lambda d, _: d["dsg"] + d["dsd"]}),
    Quantity(
        "dtheta",
        4,
        dtheta,
        rel=REL,
        abs=ABS,
        slips={
            "roues_echangees": lambda d, _: (d["dsg"] - d["dsd"]) / d["L"],
            "demi_entraxe": lambda d, _: (d["dsd"] - d["dsg"]) / (d["L"] / 2),
            "entraxe_oublie": lambda d, _: d["dsd"] - d["dsg"],
            "degres": lambda d, f: math.degrees(dtheta(d, f)),
        },
    ),
    Quantity(
        "x",
        2,
        x,
        rel=0.0,
        abs=0.0006,
        slips={
            "cap_du_depart": lambda d, f: d["x0"] + f["ds"] * math.cos(d["theta0"]),
            "cap_d_arrivee": lambda d, f: d["x0"] + f["ds"] * math.cos(d["theta0"] + f["dtheta"]),
        },
    ),
    Quantity(
        "y",
        2,
        y,
        rel=0.0,
        abs=0.0006,
        slips={
            "cap_du_depart": lambda d, f: d["y0"] + f["ds"] * math.sin(d["theta0"]),
            "cap_d_arrivee": lambda d, f: d["y0"] + f["ds"] * math.sin(d["theta0"] + f["dtheta"]),
        },
    ),
    Quantity("theta", 2, theta, rel=REL, abs=ABS, slips={"degres": lambda d, f: math.degrees(theta(d, f))}),
    Quantity(
        "sigma_dtheta",
        4,
        sigma_dtheta,
        rel=0.015,
        slips={
            "somme_des_ecarts": lambda d, _: 2 * d["sigma"] / d["L"],
            "une_seule_roue": lambda d, _: d["sigma"] / d["L"],
        },
    ),
    Quantity(
        "sigma_theta",
        2,
        sigma_theta,
        rel=0.015,
        slips={
            "fois_n": lambda d, f: d["n"] * f["sigma_dtheta"] * MILLI,
            "sans_racine_de_n": lambda d, f: f["sigma_dtheta"] * MILLI,
        },
    ),
    Quantity(
        "derive",
        2,
        drift,
        rel=0.02,
        slips={
            "un_seul_pas": lambda d, f: f["ds"] * f["sigma_theta"],
            "ecart_type_de_la_derive": deviation,
        },
    ),
)

DEFINITION = numeric(__file__, deal=deal, quantities=QUANTITIES)
