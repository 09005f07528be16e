from functools import reduce


def fusion(un, autre):
    somme = un["v"] + autre["v"]
    return {"m": sum(p["m"] * o["v"] for p, o in ((un, autre), (autre, un))) / somme, "v": un["v"] * autre["v"] / somme}


def corriger(m, v, z, r):
    avis = [{"m": m, "v": v}, {"m": z, "v": r}]
    return tuple(reduce(fusion, avis).values())


def predire(m, v, u, q):
    return tuple(sum(couple) for couple in zip((m, v), (u, q)))
