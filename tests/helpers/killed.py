"""Saves that end in the midst, by a signal: what is left is the old file or the new."""

from __future__ import annotations

import gc
import os
import resource
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any


def killed(save: Callable[[], object], point: str, number: int) -> signal.Signals | int:
    """Return the signal that ends a fork of this process while it saves; 0 where none does.

    Args:
        point: `fsync` or `replace`: SIGKILL at the so manieth call; `write`: SIGXFSZ once a file
            has so many bytes.
    """
    pid = os.fork()
    if pid == 0:
        gc.disable()  # a fork cannot free what other tests left of the middleware
        try:
            if point == "write":
                signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
                resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
                resource.setrlimit(resource.RLIMIT_FSIZE, (number, number))
            else:
                owner: Any = os if point == "fsync" else Path
                setattr(owner, point, _killing(getattr(owner, point), number))
            save()
        finally:
            os._exit(0)
    return os.WTERMSIG(os.waitpid(pid, 0)[1])


def _killing(call: Callable[..., Any], number: int) -> Callable[..., Any]:
    calls = iter(range(1, number))

    def wrapped(*arguments: Any) -> Any:
        if next(calls, None) is None:
            os.kill(os.getpid(), signal.SIGKILL)
        return call(*arguments)

    return wrapped
