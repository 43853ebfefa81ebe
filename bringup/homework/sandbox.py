"""A sandbox that a process puts itself into for good: Landlock, namespaces, seccomp, limits.

Sources: landlock(7), user_namespaces(7), seccomp(2), linux/landlock.h, linux/audit.h and the
kernel's tables of system calls. It stands on the standard library alone, for it is closed before
anything else is imported: namespaces and Landlock are of a process of one thread.
"""

from __future__ import annotations

import contextlib
import ctypes
import errno
import fcntl
import os
import platform
import resource
import signal
import socket
import struct
from collections.abc import Iterable
from pathlib import Path

_LIBC = ctypes.CDLL(None, use_errno=True)
_PR_SET_PDEATHSIG, _PR_SET_DUMPABLE, _PR_SET_NO_NEW_PRIVS = 1, 4, 38
_NEW_MOUNT, _NEW_UTS, _NEW_IPC, _NEW_USER, _NEW_NET = (1 << bit for bit in (17, 26, 27, 28, 30))
_PRIVATE, _NO_SUID_OR_DEVICES = 1 << 18 | 1 << 14, 2 | 4
_CREATE, _ADD, _RESTRICT = 444, 445, 446  # landlock's, of every architecture
_EXECUTE, _READ, _ANY = 1 << 0, 1 << 2 | 1 << 3, (1 << 13) - 1
_AUDIT = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}
# Files, mounts and names are Landlock's; here is what reaches other processes and the network.
_CALLS: dict[str, tuple[int, ...]] = {
    "x86_64": (
        *(41, 42, 53, 57, 58, 59, 62, 101, 129, 200, 234, 297, 310, 311, 322, 424, 434, 438, 440),
        *(29, 64, 68, 240, 141, 203, 248, 249, 250, 251, 256, 272, 279, 298, 308, 312),
        *(314, 321, 323, 425, 426, 427, 448),
    ),
    "aarch64": (
        *(198, 203, 199, 221, 129, 117, 138, 130, 131, 240, 270, 271, 281, 424, 434, 438, 440),
        *(194, 190, 186, 180, 140, 122, 217, 218, 219, 30, 238, 97, 239, 241, 268, 272),
        *(274, 280, 282, 425, 426, 427, 448),
    ),
}
"""System calls that are refused: socket, connect, socketpair, fork, vfork, execve, kill, ptrace,
rt_sigqueueinfo, tkill, tgkill, rt_tgsigqueueinfo, process_vm_*, execveat, pidfd_*,
process_madvise; shmget, semget, msgget, mq_open, setpriority, sched_set*, keys, ioprio_set,
*_pages, unshare, perf_event_open, setns, kcmp, bpf, userfaultfd, io_uring_*, process_mrelease."""
_IGNORED = {"x86_64": (142, 144), "aarch64": (118, 119)}
"""Calls that do nothing and succeed: sched_setparam, sched_setscheduler. Fast DDS calls them as its
threads start, before or after the seal, and would print that it may not."""
_CLONE, _CLONE3, _PRLIMIT, _SECCOMP = (
    {"x86_64": 56, "aarch64": 220},
    435,
    {"x86_64": 302, "aarch64": 261},
    {"x86_64": 317, "aarch64": 277},
)
_THREAD = 1 << 16
_ALLOW, _REFUSE = 0x7FFF0000, 0x00050000
SHARED = Path("/dev/shm")  # noqa: S108 - what Fast DDS' threads meet in


class SandboxError(Exception):
    """The kernel does not let a process confine itself."""


def separate(work: Path, size: int) -> bool:
    """Leave for namespaces of one's own: no network, and empty folders in memory.

    Args:
        work: The folder to work in.
        size: Of each folder [bytes].

    Returns:
        Whether the kernel lets users do that; without it Landlock and seccomp hold alone.
    """
    user, group = os.getuid(), os.getgid()
    if _LIBC.unshare(_NEW_USER | _NEW_MOUNT | _NEW_NET | _NEW_IPC | _NEW_UTS):
        return False
    own = {"setgroups": "deny", "uid_map": f"{user} {user} 1", "gid_map": f"{group} {group} 1"}
    for name, text in own.items():
        with contextlib.suppress(OSError), open(f"/proc/self/{name}", "w") as file:  # noqa: PTH123
            file.write(text)
    options = f"size={size},mode=700".encode()
    failed = _LIBC.mount(None, b"/", None, _PRIVATE, None)
    for folder in (work, SHARED):
        failed |= _LIBC.mount(b"tmpfs", bytes(folder), b"tmpfs", _NO_SUID_OR_DEVICES, options)
    with socket.socket() as any_socket:  # the loopback's flags: up
        fcntl.ioctl(any_socket, 0x8914, struct.pack("16sH14x", b"lo", 1))
    return not failed


def confine(read: Iterable[Path], write: Iterable[Path]) -> int:
    """Let this process read some paths and write some folders, for good.

    Returns:
        A descriptor by which `seal` reads how much memory the process has.

    Raises:
        SandboxError: The kernel has no Landlock.
    """
    version = _LIBC.syscall(_CREATE, None, 0, 1)
    if version < 1:
        raise SandboxError("the kernel has no Landlock (Linux 5.13, 'landlock' among its LSMs)")
    # Each version knows more kinds of access: renaming elsewhere, truncating, devices' ioctl.
    known = _ANY | sum(1 << bit for bit, since in ((13, 2), (14, 3), (15, 5)) if version >= since)
    network, scopes = (3 if version >= since else 0 for since in (4, 6))
    size = 24 if version >= 6 else 16 if version >= 4 else 8
    rules = _LIBC.syscall(_CREATE, struct.pack("QQQ", known, network, scopes), size, 0)
    for path in (*read, *map(Path, ("/dev/urandom", "/etc/localtime"))):
        _allow(rules, path, _READ)
    for path in (*write, Path("/dev/null")):
        _allow(rules, path, known & ~_EXECUTE)
    memory = os.open("/proc/self/statm", os.O_RDONLY)
    _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    _LIBC.prctl(_PR_SET_DUMPABLE, 0)  # nobody of the same user reads its memory
    _LIBC.prctl(_PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0)
    if _LIBC.syscall(_RESTRICT, rules, 0):
        raise SandboxError(f"Landlock refuses: {os.strerror(ctypes.get_errno())}")
    os.close(rules)
    return memory


def _allow(rules: int, path: Path, access: int) -> None:
    try:
        descriptor = os.open(path, os.O_PATH)
    except OSError:  # what is not there cannot be read
        return
    of_files = 1 << 0 | 1 << 1 | 1 << 2 | 1 << 14 | 1 << 15  # others are of folders
    access &= -1 if path.is_dir() else of_files
    _LIBC.syscall(_ADD, rules, 1, struct.pack("=Qi", access, descriptor), 0)
    os.close(descriptor)


def limit(cpu: int, file_size: int, open_files: int = 256) -> None:
    """Limit the CPU time [s], the size of a file [bytes] and the number of open files."""
    limits = {
        resource.RLIMIT_CPU: cpu,
        resource.RLIMIT_FSIZE: file_size,
        resource.RLIMIT_NOFILE: open_files,
        resource.RLIMIT_CORE: 0,
    }
    for what, most in limits.items():
        resource.setrlimit(what, (most, most))


def seal(memory: int, more: int) -> None:
    """Refuse all threads new processes, sockets and signals, and much more memory [bytes].

    Raises:
        SandboxError: The kernel has no filters of system calls.
    """
    machine = platform.machine()
    if machine not in _AUDIT:
        raise SandboxError(f"no system calls are known of {machine}; valid: {', '.join(_AUDIT)}")
    program = ctypes.create_string_buffer(_filter(machine))
    header = struct.pack("HxxxxxxQ", len(program) // 8, ctypes.addressof(program))
    if _LIBC.syscall(_SECCOMP[machine], 1, 1, header):  # SET_MODE_FILTER, TSYNC
        raise SandboxError(f"seccomp refuses: {os.strerror(ctypes.get_errno())}")
    pages = int(os.pread(memory, 64, 0).split()[0])
    most = pages * resource.getpagesize() + more
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    os.close(memory)


def _filter(machine: str) -> bytes:
    """Return the program that the kernel runs at each system call (BPF, linux/filter.h)."""

    def load(offset: int) -> bytes:  # of struct seccomp_data: number, architecture, arguments
        return struct.pack("=HBBI", 0x20, 0, 0, offset)

    def end(value: int) -> bytes:
        return struct.pack("=HBBI", 0x06, 0, 0, value)

    def on(kind: int, value: int, then: bytes, otherwise: bytes = b"") -> bytes:
        """Run some steps of 8 bytes where a comparison holds, else others."""
        return struct.pack("=HBBI", kind, 0, len(then) // 8, value) + then + otherwise

    equal, at_least, has_bits = 0x15, 0x35, 0x45
    refuse, allow = end(_REFUSE | errno.EPERM), end(_ALLOW)
    return b"".join(
        (
            load(4),
            struct.pack("=HBBI", equal, 1, 0, _AUDIT[machine]) + refuse,
            load(0),
            on(at_least, 1 << 30, refuse),  # numbers of x32
            *(on(equal, number, refuse) for number in _CALLS[machine]),
            *(on(equal, number, end(_REFUSE)) for number in _IGNORED[machine]),
            on(equal, _CLONE3, end(_REFUSE | errno.ENOSYS)),  # then libc takes clone
            on(equal, _CLONE[machine], load(16) + on(has_bits, _THREAD, allow, refuse)),
            on(equal, _PRLIMIT[machine], load(16) + on(equal, 0, allow, refuse)),
            allow,
        )
    )
