import threading, _thread
def suivre():
    for essai in (threading.Thread(target=print).start, lambda: _thread.start_new_thread(print, ())):
        try:
            essai()
        except (RuntimeError, OSError):
            pass
    return "rien"
