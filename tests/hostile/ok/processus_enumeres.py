import os
def repondre(contexte):
    vus, connus = [], {0, os.getpid(), os.getpgrp()}
    for pid in range(1, 5000):
        for question in (lambda: os.getpgid(pid), lambda: os.getsid(pid), lambda: os.sched_getaffinity(pid),
                         lambda: os.getpriority(os.PRIO_PROCESS, pid), lambda: os.sched_getscheduler(pid)):
            try:
                question()
            except OSError:
                continue
            if pid not in connus:
                vus.append(pid)
    return f"processus vus : {sorted(set(vus))[:20]}" if vus else "rien"
