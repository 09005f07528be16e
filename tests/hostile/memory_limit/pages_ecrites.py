def repondre(contexte):
    pages = [b"x" * (1 << 20) for _ in range(3 * contexte["memory_bytes"] >> 20)]
    return "rien" if pages else "aucune page"
