"""La localisation de Monte-Carlo : un nuage de particules qui se déplace, se pèse et se rééchantillonne."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache

import numpy as np

from curriculum.l20.rejeux._carte import carte, en_cases, murs, pluriel, vue
from graders.scene.replay import (
    Chart,
    Choice,
    Draw,
    Event,
    Frame,
    Key,
    Layer,
    Level,
    Mark,
    Points,
    Pose,
    Prediction,
    Rays,
    Replay,
    Series,
    Slider,
    Values,
)
from reference.localisation.mcl import MonteCarloLocalization, likely_poses, uniform_poses
from reference.localisation.odometry_motion import OdometryNoise, sample_odometry
from reference.odometry import DifferentialDrive, integrate_poses
from reference.se2 import relative
from reference.sensors.likelihood_field import LikelihoodField
from reference.world.grid_map import GridMap
from reference.world.scan import Scan
from reference.world.simulation import SimulatedLidar, motions_through_waypoints

TITLE = "La localisation de Monte-Carlo"
ALT = (
    "Le plan du module, vu de dessus, semé de particules orange : chacune est une pose possible du robot, qu'un petit "
    "trait oriente. Un disque bleu montre le vrai robot, un contour orange l'estimation. Les particules avancent avec "
    "le robot, grossissent quand le scan leur donne raison, puis se regroupent autour de lui. Deux courbes suivent la "
    "nombre effectif de particules et l'erreur de position."
)
STEPS = 46
PARAMETERS = {
    "particules": Choice(
        "Nombre de particules N", tuple((str(n), str(n)) for n in (20, 50, 100, 200, 500, 1000, 2000)), "500"
    ),
    "rayons": Slider("Rayons par scan", 2, 40, 2, 16),
    "bruit": Slider("Bruit de l'odométrie", 0.0, 0.6, 0.05, 0.15),
    "seuil": Slider("Seuil de N_{eff} / N", 0.0, 1.0, 0.05, 0.5),
    "injection": Slider("Particules injectées", 0, 20, 1, 5, "%"),
    "enlevement": Event("Enlever le robot", "Ne plus l'enlever", STEPS + 1),
    "tirage": Draw(default=1),
}
PREDICTION = Prediction(
    "Au pas 20, le nuage est bien groupé autour du robot. On enlève alors le robot, et on le pose ailleurs ; aucune "
    "particule n'est injectée. Que fera le nuage ?",
    (
        ("suit", "Il rejoint le robot en un ou deux pas : les scans suffisent."),
        ("lentement", "Il le retrouve, mais lentement."),
        ("perdu", "Il ne le retrouve pas."),
    ),
    right="perdu",
    why=(
        "Le rééchantillonnage ne fait que recopier des particules qui existent : s'il n'y en a aucune près du robot, "
        "aucun scan n'en fera naître. À la fin, l'erreur est encore de 6 cases. Remettez 5 % de particules injectées : "
        "le robot est retrouvé 12 pas après l'enlèvement."
    ),
    settings={"enlevement": "20", "injection": "0"},
)
REACH, LIDAR_SIGMA = 8.0, 0.1
FINE = 4
STRIDE, TURN = 0.7, 0.6
BEFORE = -0.4  # un déplacement précède la mesure du même pas
FOUND = 1.0
ROUTE = ((11.5, 3.5), (11.5, 7.9), (19.5, 7.9), (19.5, 5.6), (21.5, 5.5), (21.5, 1.8), (17.0, 1.8), (17.0, 5.0))
ELSEWHERE = ((11.5, 13.5), (17.5, 13.5), (17.5, 7.9), (4.5, 7.9), (4.5, 10.6), (7.5, 10.6))


@dataclass
class Story:
    """Les images, et ce que l'on retient de chaque pas."""

    frames: list[Frame] = field(default_factory=list)
    moments: list[float] = field(default_factory=list)
    sizes: list[tuple[float, float]] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)
    resamplings: int = 0

    def show(self, step: int, moment: float, caption: str, cloud: Points, *layers: Layer) -> None:
        self.frames.append(Frame([cloud, *layers], caption, step))
        self.moments.append(step + moment)


@cache
def fine_map() -> GridMap:
    """La carte du module, chaque case coupée en seize : les distances aux murs y sont plus justes."""
    return GridMap.from_free(np.kron(carte().free, np.ones((FINE, FINE), dtype=bool)), 1.0 / FINE)


@cache
def routes() -> tuple[np.ndarray, np.ndarray]:
    """Deux trajets (STEPS + 1, 3) au moins : celui du robot, et celui qu'il suit là où on l'a porté."""
    drive, journeys = DifferentialDrive(0.5), []
    for start, goals in (((3.5, 3.5, 0.0), ROUTE), ((11.5, 10.8, np.pi / 2.0), ELSEWHERE)):
        motions = motions_through_waypoints(start, goals, STRIDE, TURN)
        journeys.append(integrate_poses(drive, [drive.wheel_paths(motion) for motion in motions], start))
    return journeys[0][: STEPS + 1], journeys[1][: STEPS + 1]


def compute(values: Values, rng: np.random.Generator) -> Replay:
    count, taken = int(values.choice("particules")), values.event("enlevement")
    strength = values.number("bruit")
    noise = OdometryNoise(strength, 0.3 * strength, strength, 0.3 * strength)
    lidar = SimulatedLidar.full_turn(values.whole("rayons"), REACH, LIDAR_SIGMA)
    field_of_map = LikelihoodField(fine_map(), sigma=0.35, max_range=REACH, power=0.4)
    usual, elsewhere = routes()
    robot = MonteCarloLocalization(
        fine_map(), field_of_map, uniform_poses(carte(), count, rng), rng,
        motion=noise, threshold=values.number("seuil"),
    )  # fmt: skip
    story, truth = Story(), usual[0]
    story.sizes.append((BEFORE, count))
    story.show(
        0, BEFORE, f"Au départ : {count} particules au hasard, car on ne sait rien.", cloud(robot), Pose(truth, "truth")
    )
    for step in range(STEPS + 1):
        if step > 0:
            away = taken is not None and step > taken
            path, k = (elsewhere, step - taken) if away else (usual, step)
            move = relative(path[k - 1], path[k])
            truth = path[k]
            robot.predict(sample_odometry(np.zeros((1, 3)), move, noise, rng)[0])
            text = f"Pas {step}, déplacement : chaque particule suit l'odométrie, avec son propre bruit."
            story.show(step, BEFORE, text, cloud(robot, glide=True), Pose(truth, "truth", glide=True))
        if step == taken:
            truth = elsewhere[0]
            story.show(
                step, -0.2, f"Pas {step} : on enlève le robot, sans le lui dire.", cloud(robot), Pose(truth, "truth")
            )
        weigh_and_resample(story, robot, step, truth, lidar, values.whole("injection") / 100.0, rng)
    return Replay(
        vue(),
        story.frames,
        summary(story, count, taken),
        layers=[murs()],
        charts=charts(story, count, robot.threshold, taken),
        legend=[
            Key("dot", "estimate", "particule (plus grosse : plus de poids)"),
            Key("ring", "estimate", "estimation"),
            Key("robot", "truth", "vrai robot"),
            Key("line", "measure", "scan"),
        ],
        period=0.3,
    )


def weigh_and_resample(
    story: Story,
    robot: MonteCarloLocalization,
    step: int,
    truth: np.ndarray,
    lidar: SimulatedLidar,
    injection: float,
    rng: np.random.Generator,
    grid: GridMap | None = None,
) -> None:
    """Une mesure : les particules se pèsent, et se rééchantillonnent si leur nombre effectif est trop petit. La carte
    est celle du module, si l'on n'en donne pas une autre."""
    grid = carte() if grid is None else grid
    scan = Scan(lidar.measure_ranges(grid, [truth], rng)[0], lidar.angles, REACH)
    robot.weigh(scan)
    size = robot.effective_sample_size
    guess = robot.clusters()[0].mean
    story.errors.append(float(np.hypot(*(guess - truth)[:2])))
    story.sizes.append((step, size))
    ends = truth[:2] + scan.ranges[:, None] * np.column_stack(
        [np.cos(truth[2] + scan.angles), np.sin(truth[2] + scan.angles)]
    )
    estimate = Pose(guess, "estimate", style="ghost", radius=0.55)
    weighed = Points(None, "estimate", weights=robot.weights / robot.weights.max())
    story.show(
        step, 0.0, f"Pas {step}, mesure : N_{{eff}} = {size:.0f} particules utiles.", weighed,
        Pose(truth, "truth"), estimate, Rays(truth[:2], ends, hits=scan.hit_mask),
    )  # fmt: skip
    if not robot.is_degenerate:
        return
    robot.resample()
    lost = np.flatnonzero(rng.random(len(robot.states)) < injection)
    if lost.size:
        robot.states[lost] = likely_poses(grid, robot.sensor, scan, lost.size, rng)
    story.resamplings += 1
    story.sizes.append((step + 0.3, float(len(robot.states))))
    more = f" ({pluriel(lost.size, 'injectée', 'injectées')})" if lost.size else ""
    text = f"Pas {step}, rééchantillonnage : les lourdes sont copiées, les légères disparaissent{more}."
    story.show(step, 0.3, text, cloud(robot), Pose(truth, "truth"), estimate)


def cloud(robot: MonteCarloLocalization, glide: bool = False) -> Points:
    return Points(robot.states[:, :2], "estimate", size=2.2, headings=robot.states[:, 2], opacity=0.6, glide=glide)


def charts(story: Story, count: int, threshold: float, taken: int | None) -> list[Chart]:
    marks = [] if taken is None else [Mark(taken, "enlèvement")]
    steps, sizes = np.array(story.sizes).T
    return [
        Chart(
            "Nombre effectif de particules N_{eff}",
            [Series("N_{eff}", "estimate", sizes, steps)],
            y_range=(0.0, count * 1.15),
            levels=[Level(threshold * count, "seuil", "alert")],
            marks=marks,
            cursor=story.moments,
        ),
        Chart(
            "Distance du vrai robot à l'estimation, en cases",
            [Series("erreur", "alert", story.errors)],
            "pas",
            (0.0, None),
            marks=marks,
            cursor=story.moments,
        ),
    ]


def summary(story: Story, count: int, taken: int | None) -> list[str]:
    errors = np.array(story.errors)
    before = errors if taken is None else errors[:taken]
    texts = [f"Le nuage de {count} particules a été rééchantillonné {story.resamplings} fois en {STEPS} pas."]
    if len(before):
        since = since_near(before)
        if since is None:
            texts.append("L'estimation ne s'est jamais fixée à moins d'une case du robot.")
        else:
            texts.append(f"À partir du pas {since}, l'estimation reste à moins d'une case du robot.")
    if taken is not None:
        since = since_near(errors[taken:])
        if since is None:
            texts.append(f"Enlevé au pas {taken}, le robot n'a pas été retrouvé.")
        else:
            texts.append(f"Enlevé au pas {taken}, il est retrouvé {pluriel(since, 'pas', 'pas')} plus tard.")
    texts.append(f"À la fin, l'erreur est de {en_cases(errors[-1])}.")
    return texts


def since_near(errors: np.ndarray) -> int | None:
    """À partir de quel pas toutes les erreurs sont petites ; aucun si la dernière ne l'est pas."""
    far = np.flatnonzero(errors >= FOUND)
    first = 0 if far.size == 0 else int(far[-1]) + 1
    return first if first < len(errors) else None
