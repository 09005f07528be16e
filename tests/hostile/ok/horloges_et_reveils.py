import ctypes, os, time
def repondre(contexte):
    libc, faits = ctypes.CDLL(None), []
    moment = (ctypes.c_long * 4)(1, 0, 1, 0)
    essais = {"timer_create": lambda: libc.timer_create(0, None, moment), "timerfd": lambda: libc.timerfd_create(1, 0),
              "clock_settime": lambda: libc.clock_settime(0, moment), "settimeofday": lambda: libc.settimeofday(moment, None),
              "signalfd": lambda: libc.signalfd(-1, moment, 0), "adjtimex": lambda: libc.adjtimex(moment), "inotify": lambda: libc.inotify_init1(0)}
    for nom, essai in essais.items():
        if essai() >= 0:
            faits.append(nom)
    return str(faits) if faits else "rien"
