class Recalage:
    """Keeps both clouds about their centres."""

    def __init__(self, P, Q):
        self.cp, self.cq = np.mean(P, axis=0), np.mean(Q, axis=0)
        self.P, self.Q = P - self.cp, Q - self.cq

    @property
    def rotation(self):
        V, _, Ut = np.linalg.svd(self.Q.T @ self.P)
        correction = np.identity(V.shape[0])
        correction[-1][-1] = 1 if np.linalg.det(V @ Ut) > 0 else -1
        return V @ correction @ Ut

    @property
    def translation(self):
        return self.cq - self.rotation @ self.cp


def kabsch(P, Q):
    recalage = Recalage(P, Q)
    return recalage.rotation, recalage.translation
