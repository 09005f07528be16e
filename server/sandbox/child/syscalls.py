"""The system calls that the filter knows, as ``name:x86-64 number/aarch64 number``.

Any other existing call kills the process: ptrace, process_vm_readv, io_uring_*, bpf, userfaultfd, keyctl, mount, setns,
unshare, open_by_handle_at, perf_event_open, kexec_load… are calls of attackers only.
"""

from __future__ import annotations

#: Computing, time, memory, and files (which Landlock and the file view bound).
ALLOWED = """
read:0/63 write:1/64 readv:19/65 writev:20/66 pread64:17/67 pwrite64:18/68 preadv:295/69 pwritev:296/70
preadv2:327/286 pwritev2:328/287 lseek:8/62 close:3/57 close_range:436/436 dup:32/23 dup2:33/ dup3:292/24 fstat:5/80
stat:4/ lstat:6/ newfstatat:262/79 statx:332/291 open:2/ openat:257/56 access:21/ faccessat:269/48 faccessat2:439/439
readlink:89/ readlinkat:267/78 getcwd:79/17 chdir:80/49 fchdir:81/50 getdents:78/ getdents64:217/61 mmap:9/222
munmap:11/215 mprotect:10/226 mremap:25/216 madvise:28/233 brk:12/214 msync:26/227 rt_sigaction:13/134
rt_sigprocmask:14/135 rt_sigreturn:15/139 rt_sigpending:127/136 rt_sigsuspend:130/133 rt_sigtimedwait:128/137
sigaltstack:131/132 set_robust_list:273/99 get_robust_list:274/100 rseq:334/293 set_tid_address:218/96
nanosleep:35/101 clock_nanosleep:230/115 clock_gettime:228/113 clock_getres:229/114 gettimeofday:96/169 time:201/
times:100/153 getitimer:36/102 setitimer:38/103 alarm:37/ pause:34/ getpid:39/172 gettid:186/178 getppid:110/173
getuid:102/174 geteuid:107/175 getgid:104/176 getegid:108/177 getgroups:115/158 getresuid:118/148 getresgid:120/150
getpgrp:111/ getrandom:318/278 uname:63/160 sysinfo:99/179 getrusage:98/165 getrlimit:97/163 sched_yield:24/124
sched_get_priority_max:146/125 sched_get_priority_min:147/126 getcpu:309/168 poll:7/ ppoll:271/73 select:23/
pselect6:270/72 epoll_create:213/ epoll_create1:291/20 epoll_ctl:233/21 epoll_wait:232/ epoll_pwait:281/22
eventfd2:290/19 pipe:22/ pipe2:293/59 exit:60/93 exit_group:231/94 restart_syscall:219/128 arch_prctl:158/
membarrier:324/283 capget:125/90 fsync:74/82 fdatasync:75/83 statfs:137/43 fstatfs:138/44 umask:95/166
"""

#: Allowed for some arguments only: see `server.sandbox.child.seccomp`.
CONDITIONAL = """
prlimit64:302/261 ioctl:16/29 clone:56/220 prctl:157/167 fcntl:72/25 futex:202/98 getpgid:121/155 getsid:124/156
getpriority:140/141 sched_getaffinity:204/123 sched_getparam:143/121 sched_getscheduler:145/120
"""

#: Refused with EPERM, so that Python raises an exception: what libraries or beginners try in good faith, and the locks
#: and caches of shared files, by which two programs could talk.
REFUSED = """
socket:41/198 socketpair:53/199 connect:42/203 bind:49/200 listen:50/201 accept:43/202 accept4:288/242
getsockname:51/204 getpeername:52/205 setsockopt:54/208 getsockopt:55/209 sendto:44/206 recvfrom:45/207 sendmsg:46/211
recvmsg:47/212 sendmmsg:307/269 recvmmsg:299/243 shutdown:48/210 fork:57/ vfork:58/ execve:59/221 execveat:322/281
wait4:61/260 waitid:247/95 kill:62/129 tkill:200/130 tgkill:234/131 rt_sigqueueinfo:129/138 rt_tgsigqueueinfo:297/240
link:86/ linkat:265/37 symlink:88/ symlinkat:266/36 chown:92/ fchown:93/55 lchown:94/ fchownat:260/54 mknod:133/
mknodat:259/33 setuid:105/146 setgid:106/144 setreuid:113/145 setregid:114/143 setresuid:117/147 setresgid:119/149
setfsuid:122/151 setfsgid:123/152 setgroups:116/159 setpgid:109/154 setsid:112/157 setpriority:141/140
sched_setparam:142/118 sched_setscheduler:144/119 sched_setaffinity:203/122 sched_setattr:314/274
sched_getattr:315/275 ioprio_set:251/30 ioprio_get:252/31 setrlimit:160/164 capset:126/91 chroot:161/51 sync:162/81
syncfs:306/267 memfd_create:319/279 mlock:149/228 munlock:150/229 mlockall:151/230 munlockall:152/231 mlock2:325/284
remap_file_pages:216/234 shmget:29/194 shmat:30/196 shmctl:31/195 shmdt:67/197 semget:64/190 semop:65/193
semctl:66/191 semtimedop:220/192 msgget:68/186 msgsnd:69/189 msgrcv:70/188 msgctl:71/187 mq_open:240/180
mq_unlink:241/181 mq_timedsend:242/182 mq_timedreceive:243/183 mq_notify:244/184 mq_getsetattr:245/185
inotify_init:253/ inotify_init1:294/26 inotify_add_watch:254/27 inotify_rm_watch:255/28 timerfd_create:283/85
timerfd_settime:286/86 timerfd_gettime:287/87 timer_create:222/107 timer_settime:223/110 timer_gettime:224/108
timer_getoverrun:225/109 timer_delete:226/111 signalfd:282/ signalfd4:289/74 eventfd:284/ splice:275/76 tee:276/77
vmsplice:278/75 getxattr:191/8 lgetxattr:192/9 fgetxattr:193/10 listxattr:194/11 llistxattr:195/12 flistxattr:196/13
setxattr:188/5 lsetxattr:189/6 fsetxattr:190/7 removexattr:197/14 lremovexattr:198/15 fremovexattr:199/16
readahead:187/213 pidfd_open:434/434 pidfd_send_signal:424/424 pidfd_getfd:438/438 landlock_create_ruleset:444/444
landlock_add_rule:445/445 landlock_restrict_self:446/446 seccomp:317/277 personality:135/92 mbind:237/235
set_mempolicy:238/237 get_mempolicy:239/236 pkey_mprotect:329/288 pkey_alloc:330/289 pkey_free:331/290
clock_settime:227/112 clock_adjtime:305/266 adjtimex:159/171 settimeofday:164/170 sethostname:170/161
setdomainname:171/162 vhangup:153/58 syslog:103/116 ustat:136/ sysfs:139/ epoll_pwait2:441/441 io_setup:206/0
io_submit:209/2 io_destroy:207/1 io_getevents:208/4 io_cancel:210/3 flock:73/32 mincore:27/232 fadvise64:221/223
"""

#: Calls that change folders and files: refused likewise where the program has no private folder.
FOLDER = """
unlink:87/ unlinkat:263/35 rename:82/ renameat:264/38 renameat2:316/276 mkdir:83/ mkdirat:258/34 rmdir:84/ chmod:90/
fchmod:91/52 fchmodat:268/53 truncate:76/45 ftruncate:77/46 fallocate:285/47 creat:85/ utime:132/ utimes:235/
utimensat:280/88 futimesat:261/ sync_file_range:277/84 copy_file_range:326/285 sendfile:40/71
"""

#: Answered with ENOSYS, so that the C library falls back on an older call.
ABSENT = """
clone3:435/435 openat2:437/437 futex_waitv:449/449 process_mrelease:448/448 memfd_secret:447/447 uselib:134/
_sysctl:156/ nfsservctl:180/42 set_mempolicy_home_node:450/450
"""

#: Calls by which a template serves and a fork raises its walls: only the fork's last filter refuses them.
SETTING_UP = """
recvmsg:47/212 sendto:44/206 wait4:61/260 kill:62/129 pidfd_open:434/434 fork:57/ clone:56/220 clone3:435/435
futex:202/98 mount:165/40 prctl:157/167 capset:126/91 landlock_restrict_self:446/446 setrlimit:160/164
prlimit64:302/261 process_madvise:440/440
"""

#: The last number described by the tables; a younger kernel's calls above it get ENOSYS.
LAST_KNOWN = 469


def system_call_numbers(table: str, column: int) -> tuple[int, ...]:
    """Numbers of one table for an architecture: column 0 is x86-64, 1 is aarch64."""
    fields = (entry.partition(":")[2].split("/")[column] for entry in table.split())
    return tuple(sorted({int(field) for field in fields if field}))


def system_call_number(name: str, column: int) -> int | None:
    """Number of one call of any table; None when the architecture has no such call."""
    for entry in " ".join((ALLOWED, CONDITIONAL, REFUSED, FOLDER, ABSENT)).split():
        if entry.partition(":")[0] == name:
            field = entry.partition(":")[2].split("/")[column]
            return int(field) if field else None
    raise KeyError(name)
