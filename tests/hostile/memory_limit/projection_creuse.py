import mmap
def repondre(contexte):
    vide = mmap.mmap(-1, contexte["memory_bytes"] * 1000, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | 0x4000)
    return len(vide)
