"""A class that holds the state, plain lists, math, a wrap by while."""
import math
from dataclasses import dataclass


@dataclass
class Robot:
    x: float
    y: float
    cap: float
    entraxe: float

    def rouler(self, gauche: float, droite: float) -> None:
        tour = (droite - gauche) / self.entraxe
        avance = 0.5 * (gauche + droite)
        self.x += avance * math.cos(self.cap + tour / 2)
        self.y += avance * math.sin(self.cap + tour / 2)
        self.cap += tour
        while self.cap > math.pi:
            self.cap -= math.tau
        while self.cap < -math.pi:
            self.cap += math.tau


def odometrie(depart, roue_gauche, roue_droite, entraxe):
    robot = Robot(*map(float, depart), entraxe)
    robot.rouler(roue_gauche, roue_droite)
    return [robot.x, robot.y, robot.cap]


def sigma_dtheta(sg, sd, entraxe):
    return math.hypot(sg / entraxe, sd / entraxe)


if __name__ == "__main__":
    raise SystemExit("never runs here")
