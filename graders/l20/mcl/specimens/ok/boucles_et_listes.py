import math


def initialiser(n):
    cases = [(y, x) for y in range(H) for x in range(W) if libres[y][x]]
    nuage = []
    for _ in range(n):
        y, x = cases[int(rng.integers(0, len(cases)))]
        nuage.append([x + rng.random(), y + rng.random(), 2 * math.pi * rng.random() - math.pi])
    return nuage


def pas_mcl(particules, poids, u, scan):
    rayons = range(0, 36, 4)
    nouvelles, logs = [], []
    for (x, y, t), w in zip(particules, poids):
        dx = u[0] + rng.normal(0, 0.08)
        dy = u[1] + rng.normal(0, 0.08)
        x2 = x + dx * math.cos(t) - dy * math.sin(t)
        y2 = y + dx * math.sin(t) + dy * math.cos(t)
        t2 = t + u[2] + rng.normal(0, 0.05)
        attendu = lidar((x2, y2, t2), 9)
        somme = 0.0
        for k, r in enumerate(rayons):
            somme -= min((scan[r] - attendu[k]) ** 2 / (2 * 0.3**2), 8)
        nouvelles.append([x2, y2, t2])
        logs.append(somme + (math.log(w) if w > 0 else -1e9))
    haut = max(logs)
    w = [math.exp(l - haut) for l in logs]
    total = sum(w)
    w = [v / total for v in w]
    n = len(w)
    if 1 / sum(v * v for v in w) < n / 2:
        tirees, i, cumul, dent = [], 0, w[0], rng.random() / n
        for _ in range(n):
            while cumul < dent and i < n - 1:
                i += 1
                cumul += w[i]
            tirees.append(list(nouvelles[i]))
            dent += 1 / n
        nouvelles, w = tirees, [1 / n] * n
    return nouvelles, w


def estimer(particules, poids):
    x = sum(w * p[0] for p, w in zip(particules, poids))
    y = sum(w * p[1] for p, w in zip(particules, poids))
    s = sum(w * math.sin(p[2]) for p, w in zip(particules, poids))
    c = sum(w * math.cos(p[2]) for p, w in zip(particules, poids))
    return [x, y, math.atan2(s, c)]
