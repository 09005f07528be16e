import g2o


def systeme(poses, amers, aretes, observations):
    return g2o.systeme(poses, amers, aretes, observations)


def slam_amers(poses, amers, aretes, observations, n_iter=10):
    return g2o.optimiser(poses, amers, aretes, observations, n_iter)
