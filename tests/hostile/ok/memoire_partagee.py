import os, mmap
from multiprocessing import shared_memory
def repondre(contexte):
    faits = []
    for nom, action in {
        "shm": lambda: shared_memory.SharedMemory("rendez-vous", create=True, size=4096),
        "memfd": lambda: os.memfd_create("rendez-vous"),
        "fifo": lambda: os.mkfifo("/dev/shm/rendez-vous"),
    }.items():
        try:
            action()
        except (OSError, ImportError):
            continue
        faits.append(nom)
    return str(faits) if faits else "rien"
