def corriger(poses, delta):
    x = poses - delta
    x[:, 2] = ramener(x[:, 2])
    return x
