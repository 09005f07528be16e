from filterpy.kalman import predict, update


def predire(x, P, F, Q):
    return predict(x, P, F, Q)


def corriger(x, P, z, H, R):
    return update(x, P, z, R, H)
