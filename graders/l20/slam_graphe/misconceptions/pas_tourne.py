def corriger(poses, delta):
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    dx, dy = c * delta[:, 0] - s * delta[:, 1], s * delta[:, 0] + c * delta[:, 1]
    return np.stack([poses[:, 0] + dx, poses[:, 1] + dy, ramener(poses[:, 2] + delta[:, 2])], axis=1)
