def repondre(contexte):
    n = 1
    while True:
        n <<= contexte["memory_bytes"]
