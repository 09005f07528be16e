def dents(n):
    dent = rng.random() / n
    for _ in range(n):
        yield dent
        dent += 1.0 / n


def n_eff(poids):
    total = carres = 0.0
    for p in poids:
        total += p
        carres += p * p
    return total * total / carres


def reechantillonner_systematique(particules, poids):
    indices, fin = iter(range(len(poids))), 0.0
    copies = []
    i = -1
    for dent in dents(len(poids)):
        while fin < dent and i < len(poids) - 1:
            i = next(indices)
            fin += poids[i]
        copies.append(particules[max(i, 0)].copy())
    return np.array(copies)
