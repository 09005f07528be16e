n_eff = lambda w: 1 / (w @ w)
cumul = lambda w: np.clip(np.cumsum(w), 0, 1)
peigne = lambda n: np.arange(rng.random() / n, 1, 1 / n)[:n]
rangs = lambda w: np.clip(np.searchsorted(cumul(w), peigne(len(w)), side="right"), 0, len(w) - 1)
reechantillonner_systematique = lambda x, w: x[rangs(w)]
