"""Honest ways to write l20/boucles: descriptors and distances that students choose, as source code."""

from __future__ import annotations

DESCRIPTORS = {
    "rfft": "np.abs(np.fft.rfft(scan))",
    "fft": "np.abs(np.fft.fft(scan))",
    "fft without mean": "np.abs(np.fft.fft(scan))[1:]",
    "first ten": "np.abs(np.fft.fft(scan))[:10]",
    "five without mean": "np.abs(np.fft.rfft(scan))[1:6]",
    "padded fft": "np.abs(np.fft.rfft(np.concatenate([scan, scan])))",
    "power": "np.abs(np.fft.rfft(scan)) ** 2",
    "log": "np.log(np.abs(np.fft.rfft(scan)) + 1e-3)",
    "log1p": "np.log1p(np.abs(np.fft.rfft(scan)))",
    "over first": "np.abs(np.fft.rfft(scan)) / np.abs(np.fft.rfft(scan))[0]",
    "unit": "np.abs(np.fft.rfft(scan)) / np.linalg.norm(np.fft.rfft(scan))",
    "of slopes": "np.abs(np.fft.rfft(np.diff(np.append(scan, scan[0]))))",
    "centred": "np.abs(np.fft.fft(scan - scan.mean()))",
    "of inverse": "np.abs(np.fft.rfft(1 / (1 + scan)))",
    "naive dft": "[abs(sum(z * cmath.exp(-2j * math.pi * f * k / 36) for k, z in enumerate(scan))) for f in range(19)]",
    "sorted": "np.sort(scan)",
    "sorted list": "sorted(scan)",
    "sorted tuple": "tuple(sorted(scan.tolist(), reverse=True))",
    "rounded": "np.round(np.sort(scan), 2)",
    "single precision": "np.abs(np.fft.rfft(scan)).astype(np.float32)",
    "histogram 10": "np.histogram(scan, bins=10, range=(0, PORTEE_MAX))[0]",
    "histogram 12": "np.histogram(scan, bins=12, range=(0, 12))[0]",
    "histogram 20": "np.histogram(scan, bins=20, range=(0, PORTEE_MAX))[0] / 36",
    "histogram 24": "np.histogram(scan, bins=np.linspace(0, PORTEE_MAX, 25))[0]",
    "histogram 36": "np.histogram(scan, bins=36, range=(0, PORTEE_MAX))[0]",
    "density": "np.histogram(scan, bins=15, range=(0, PORTEE_MAX), density=True)[0]",
    "own boxes": "np.histogram(scan, bins=10)[0]",
    "floors": "np.bincount(np.clip(scan, 0, 12).astype(int), minlength=13)",
    "cumulated": "np.cumsum(np.histogram(scan, bins=10, range=(0, PORTEE_MAX))[0])",
    "autocorrelation": "np.array([np.sum(scan * np.roll(scan, k)) for k in range(36)])",
    "autocorrelation fft": "np.fft.ifft(np.abs(np.fft.fft(scan)) ** 2)",
    "autocorrelation real": "np.fft.irfft(np.abs(np.fft.rfft(scan)) ** 2)",
    "covariance": "[float(np.mean((scan - scan.mean()) * (np.roll(scan, k) - scan.mean()))) for k in range(19)]",
    "variogram": "np.array([np.mean((scan - np.roll(scan, k)) ** 2) for k in range(1, 19)])",
    "bispectrum": "(lambda Z: np.array([Z[1] * Z[k] * np.conj(Z[k + 1]) for k in range(1, 9)]))(np.fft.fft(scan))",
    "quartiles": "np.percentile(scan, [0, 25, 50, 75, 100])",
    "deciles": "np.quantile(scan, np.linspace(0, 1, 11))",
    "mean std": "np.array([np.mean(scan), np.std(scan)])",
    "five numbers": "np.array([scan.mean(), scan.std(), scan.min(), scan.max(), np.median(scan)])",
    "sums of powers": "np.array([np.sum(scan), np.sum(scan**2), np.sum(scan**3)])",
    "moments": "np.array([scan.mean(), scan.var(), scipy.stats.skew(scan), scipy.stats.kurtosis(scan)])",
    "area and perimeter": "np.array([0.5 * np.sum(scan * np.roll(scan, 1)) * np.sin(np.pi / 18), np.sum(np.sqrt("
    "scan**2 + np.roll(scan, 1)**2 - 2 * scan * np.roll(scan, 1) * np.cos(np.pi / 18)))])",
    "steps": "np.sort(np.abs(scan - np.roll(scan, 1)))",
    "steps histogram and mean": "np.append(np.histogram(np.abs(np.diff(scan, append=scan[0])), bins=8,"
    " range=(0, PORTEE_MAX))[0], scan.mean())",
    "smallest rotation": "min(tuple(np.roll(scan, k)) for k in range(36))",
    "mixed": "np.concatenate([np.abs(np.fft.rfft(scan))[:6], np.sort(scan)[::6], [scan.std()]])",
    "huge": "1e9 * np.abs(np.fft.rfft(scan)) ** 2",
    "tiny": "1e-9 * np.sort(scan)",
}

DISTANCES = {
    "L2": "np.linalg.norm(a - b)",
    "L1": "np.sum(np.abs(a - b))",
    "max": "np.max(np.abs(a - b))",
    "squared": "np.sum(np.abs(a - b) ** 2)",
    "rmse": "np.sqrt(np.mean(np.abs(a - b) ** 2))",
    "mae": "np.mean(np.abs(a - b))",
    "relative": "np.linalg.norm(a - b) / np.linalg.norm(b)",
    "cosine": "1 - abs(np.vdot(a, b)) / (np.linalg.norm(a) * np.linalg.norm(b))",
    "loop": "math.sqrt(sum(abs(x - y) ** 2 for x, y in zip(a, b)))",
}

LIST = """
    r = []
    a = np.asarray(signature(scans[i]))
    for j in range(len(scans)):
        b = np.asarray(signature(scans[j]))
        if j <= i - 10 and {distance} <= seuil:
            r.append(j)
    return r
"""
ARRAY = """
    S = [np.asarray(signature(s)) for s in scans]
    distance = lambda a, b: {distance}
    d = np.array([distance(S[i], S[j]) for j in range(max(0, i - 9))])
    return np.where(d < seuil)[0]
"""


def submission(descriptor: str, distance: str = DISTANCES["L2"], body: str = LIST) -> str:
    """A whole program: the expression of a signature, that of the distance between signatures a and b, a style."""
    return (
        "import cmath, math\nimport scipy.stats\n\n"
        f"def signature(scan):\n    return {descriptor}\n\n"
        f"def candidats_boucle(scans, i, seuil):{body.format(distance=distance)}"
    )
