"""The system calls that a sealed process may make, and the filter of them.

A process that reads a film needs to read and write open files, to compute on threads and to exit.  All else is refused:
the network, other programs, other processes, and changes of file permissions.

A call that is not allowed here fails with "not implemented", so that a newer C library falls back to an older call.
Source: the groups of systemd (`systemd-analyze syscall-filter`) and the default profile of container engines, with the
    calls that FFmpeg, OpenCV and NumPy were seen to make; by libseccomp (`seccomp.py`).
"""

from __future__ import annotations

import errno
import os

from moireid.sandbox.seccomp import ALLOW, EQ, MASKED_EQ, Argument, Filter, refuse

#: clone(2): the new task is a thread of this process.
CLONE_THREAD = 0x10000
#: ioctl(2) that Python asks of files: are you a terminal, how wide, how much is there, and close at exec.
FILE_QUESTIONS = (0x5401, 0x5413, 0x541B, 0x5421, 0x5450, 0x5451)
#: fcntl(2): copies, flags and locks of open files, the size of a pipe, and seals of memory; and not F_SETOWN, F_SETSIG
#: and F_SETOWN_EX, by which the kernel sends a signal of one's choice to a process of one's choice.
FILE_COMMANDS = (*range(8), *range(12, 15), 36, 37, 38, 1030, 1031, 1032, 1034)
#: An int: the kernel looks at no more of an argument.
INT = 0xFFFFFFFF

ALLOWED = {
    "files": "read write readv writev pread64 pwrite64 preadv pwritev preadv2 pwritev2 creat "
    "close close_range stat lstat fstat newfstatat stat64 lstat64 fstat64 fstatat64 statx statfs fstatfs statfs64 "
    "fstatfs64 lseek _llseek access faccessat faccessat2 readlink readlinkat getdents getdents64 getcwd chdir fchdir "
    "mkdir mkdirat rmdir unlink unlinkat rename renameat renameat2 ftruncate ftruncate64 fallocate fadvise64 fsync "
    "fdatasync flock dup dup2 dup3 pipe pipe2 umask sendfile sendfile64 copy_file_range",
    "memory": "brk mmap mmap2 munmap mremap mprotect madvise mlock mlock2 munlock msync mincore membarrier "
    "get_mempolicy set_mempolicy mbind",
    "threads": "futex futex_time64 futex_waitv set_robust_list get_robust_list set_tid_address rseq gettid getcpu "
    "sched_yield sched_getaffinity sched_getparam sched_getscheduler sched_get_priority_max "
    "sched_get_priority_min arch_prctl set_thread_area exit exit_group wait4 waitid restart_syscall",
    "itself": "getpid getppid getpgrp getpgid getsid getuid geteuid getgid getegid getuid32 geteuid32 getgid32 "
    "getegid32 getgroups getresuid getresgid getrusage getrlimit ugetrlimit setrlimit times sysinfo uname prctl "
    "capget",
    "signals": "rt_sigaction rt_sigprocmask rt_sigreturn sigreturn sigaltstack rt_sigtimedwait rt_sigsuspend "
    "rt_sigpending pause alarm getitimer setitimer",
    "time": "clock_gettime clock_gettime64 clock_getres clock_getres_time64 clock_nanosleep clock_nanosleep_time64 "
    "nanosleep gettimeofday time timerfd_create timerfd_settime timerfd_gettime",
    "waiting": "poll ppoll ppoll_time64 select _newselect pselect6 pselect6_time64 epoll_create epoll_create1 "
    "epoll_ctl epoll_wait epoll_pwait epoll_pwait2 eventfd eventfd2",
    "chance": "getrandom",
}


def filter_calls() -> None:
    """Refuse all other system calls to this process and all its threads; this cannot be undone.

    Raises: OSError where the kernel refuses, and without libseccomp.
    """
    with Filter(refuse(errno.ENOSYS)) as rules:
        _add_rules(rules)
        rules.load()


def _add_rules(rules: Filter) -> None:
    """Add the rules of `ALLOWED`, and those that look at arguments.  Raises: OSError."""
    own = os.getpid()

    def allow(name: str, *where: Argument) -> None:
        try:
            rules.add(ALLOW, name, *where)
        except (OSError, LookupError):
            # This library, or this processor, has no such call; then it gives "not implemented".
            if name in ("read", "write", "mmap", "futex", "exit_group"):
                raise

    for name in " ".join(ALLOWED.values()).split():
        allow(name)
    allow("clone", Argument(0, MASKED_EQ, CLONE_THREAD, CLONE_THREAD))
    for name in ("kill", "tgkill"):
        allow(name, Argument(0, EQ, own))
    for process in (0, own):
        for name in ("prlimit64", "sched_setaffinity"):
            allow(name, Argument(0, EQ, process))
    for name in ("fcntl", "fcntl64"):
        for command in FILE_COMMANDS:
            allow(name, Argument(1, MASKED_EQ, INT, command))
    # A process that may read a file could truncate it: Landlock refuses that only since Linux 6.2.
    # openat2 is left out, as its flags lie in memory, where a filter cannot look.
    for name, place in (("open", 1), ("openat", 2)):
        allow(name, Argument(place, MASKED_EQ, os.O_TRUNC, 0))
        for way in (os.O_WRONLY, os.O_RDWR):
            allow(name, Argument(place, MASKED_EQ, os.O_TRUNC | os.O_ACCMODE, os.O_TRUNC | way))
    for question in FILE_QUESTIONS:
        allow("ioctl", Argument(1, EQ, question))
