"""Horn's quaternions in space, the closed-form angle in the plane; lists returned, other parameter names."""
from math import atan2, cos, sin


def kabsch(source, cible):
    n, d = len(source), len(source[0])
    c1 = [sum(p[k] for p in source) / n for k in range(d)]
    c2 = [sum(p[k] for p in cible) / n for k in range(d)]
    S = [[sum((p[i] - c1[i]) * (q[j] - c2[j]) for p, q in zip(source, cible)) for j in range(d)] for i in range(d)]
    R = dans_le_plan(S) if d == 2 else dans_l_espace(S)
    t = [c2[i] - sum(R[i][j] * c1[j] for j in range(d)) for i in range(d)]
    return [R, t]


def dans_le_plan(S):
    angle = atan2(S[0][1] - S[1][0], S[0][0] + S[1][1])
    return [[cos(angle), -sin(angle)], [sin(angle), cos(angle)]]


def dans_l_espace(S):
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = S
    N = [
        [xx + yy + zz, yz - zy, zx - xz, xy - yx],
        [yz - zy, xx - yy - zz, xy + yx, zx + xz],
        [zx - xz, xy + yx, yy - xx - zz, yz + zy],
        [xy - yx, zx + xz, yz + zy, zz - xx - yy],
    ]
    w, x, y, z = np.linalg.eigh(np.array(N))[1][:, 3]
    return [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
