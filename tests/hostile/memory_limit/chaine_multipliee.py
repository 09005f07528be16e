def repondre(contexte):
    return len("x" * (2 * contexte["memory_bytes"]))
