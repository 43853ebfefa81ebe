"""A headless Chromium, driven through its DevTools protocol."""

from __future__ import annotations

import base64
import json
import os
import shutil
import subprocess
import time
import urllib.request
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Any

from websockets.sync.client import ClientConnection, connect

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
WIDTH, HEIGHT = 800, 520
_START = 120.0  # [s, wall] for an answer of a page on a busy machine
_ENDING = 5.0
_POLL = 0.1
_FLAGS = (
    *("--headless=new", "--no-sandbox", "--disable-gpu-sandbox", "--no-first-run"),
    *("--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--remote-debugging-port=0"),
    *("--hide-scrollbars", "--disable-background-networking", "--disable-dev-shm-usage"),
)


def find() -> str | None:
    """Return the Chromium that is installed, or None."""
    return next((path for name in NAMES if (path := shutil.which(name))), None)


class Page:
    """One page in a browser of its own; a context manager.

    Args:
        program: The browser.
        folder: An empty folder for its profile.
    """

    def __init__(self, program: str, folder: Path, address: str) -> None:
        profile, size = f"--user-data-dir={folder}", f"--window-size={WIDTH},{HEIGHT}"
        self._process = subprocess.Popen(
            [program, *_FLAGS, profile, size, "about:blank"],
            env={**os.environ, "LC_ALL": "en_US.UTF-8"},  # of "C" a page's number formats throw
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        port_file = folder / "DevToolsActivePort"
        self._until(lambda: port_file.exists() and port_file.read_text().count("\n") > 0)
        port = int(port_file.read_text().splitlines()[0])
        self._socket = self._attach(port)
        self._number = 0
        size_now = {"width": WIDTH, "height": HEIGHT, "deviceScaleFactor": 1, "mobile": False}
        self.call("Emulation.setDeviceMetricsOverride", **size_now)
        # a headless page that asks for no frames is given none, and its pictures wait for one
        frames = "(function next() { requestAnimationFrame(next); })()"
        self.call("Page.addScriptToEvaluateOnNewDocument", source=frames)
        self.call("Page.navigate", url=address)

    def _attach(self, port: int) -> ClientConnection:
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/json/list", timeout=_START) as reply:
            pages = json.load(reply)
        url = next(page["webSocketDebuggerUrl"] for page in pages if page["type"] == "page")
        return connect(url, max_size=None)

    def _until(self, done: Callable[[], bool]) -> None:
        end = time.monotonic() + _START
        while not done():
            assert time.monotonic() < end, "the browser does not start"
            assert self._process.poll() is None, "the browser ended"
            self.wait(_POLL)

    def wait(self, duration: float) -> None:
        """Let the page run for a while [s]."""
        try:
            self._process.wait(timeout=duration)
        except subprocess.TimeoutExpired:
            return

    def call(self, method: str, **parameters: Any) -> Any:
        """Call a method of the protocol and return its result."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        self._socket.send(json.dumps(message))
        while True:
            reply = json.loads(self._socket.recv(timeout=_START))
            if reply.get("id") == self._number:
                assert "error" not in reply, f"{method}: {reply['error']}"
                return reply["result"]

    def evaluate(self, script: str) -> Any:
        """Return the value of an expression in the page."""
        result = self.call("Runtime.evaluate", expression=script, returnByValue=True)
        return result["result"].get("value")

    def draw(self, pictures: int = 3) -> None:
        """Wait until the page has drawn some more pictures."""
        script = (
            "new Promise(done => (function next(n) {"
            f" n ? requestAnimationFrame(() => next(n - 1)) : done() }})({pictures}))"
        )
        self.call("Runtime.evaluate", expression=script, awaitPromise=True)

    def text(self) -> str:
        """Return the page's text."""
        return str(self.evaluate("document.body.innerText"))

    def press(self, label: str) -> None:
        """Click the button of a label."""
        script = (
            "(() => { const all = [...document.querySelectorAll("
            "'button, label, [role=button], [style*=pointer]')];"  # the last are folders' heads
            " const words = e => (e.innerText || '').replace('●', '').trim();"
            f" const it = all.find(e => words(e) === {json.dumps(label)});"
            " if (!it) return null; it.scrollIntoView({block: 'center'});"
            " const r = it.getBoundingClientRect();"
            " return [r.x + r.width / 2, r.y + r.height / 2]; })()"
        )
        point = self.evaluate(script)
        assert point is not None, f"no button {label!r} in: {self.text()}"
        self.drag(point, point)

    def choose(self, label: str, option: str) -> None:
        """Choose an option of the list that has a label."""
        rows = "[...document.querySelectorAll('label')]"
        field = (
            f"(() => {{ const it = {rows}.find(e => e.innerText.trim() === {json.dumps(label)});"
            " const box = it.closest('div').parentElement.querySelector('input');"
            " box.scrollIntoView({block: 'center'}); const r = box.getBoundingClientRect();"
            " return [r.x + r.width / 2, r.y + r.height / 2]; })()"
        )
        point = self.evaluate(field)
        assert point is not None, f"no list {label!r} in: {self.text()}"
        self.drag(point, point)
        chosen = (
            "(() => { const all = [...document.querySelectorAll('[role=option]')];"
            f" const it = all.find(e => e.innerText.trim() === {json.dumps(option)});"
            " if (!it) return all.map(e => e.innerText); it.click(); return true; })()"
        )
        for _ in range(20):
            self.wait(_POLL)
            found = self.evaluate(chosen)
            if found is True:
                return
        raise AssertionError(f"no option {option!r} of {label!r}: {found}")

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        """Press the left button at a point [pixels], move, release at another."""
        self._mouse("mouseMoved", start, 0)
        self._mouse("mousePressed", start, 1)
        if start != end:
            for share in (0.25, 0.5, 0.75, 1.0):
                here = tuple(a + share * (b - a) for a, b in zip(start, end, strict=True))
                self._mouse("mouseMoved", (here[0], here[1]), 1)
                self.wait(_POLL)
        self._mouse("mouseReleased", end, 0)

    def _mouse(self, kind: str, point: tuple[float, float], buttons: int) -> None:
        button = "none" if kind == "mouseMoved" and not buttons else "left"
        self.call(
            *("Input.dispatchMouseEvent",),
            type=kind, x=point[0], y=point[1], button=button, buttons=buttons, clickCount=1,
        )  # fmt: skip

    def screenshot(self) -> bytes:
        """Return the page as a PNG."""
        return base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])

    def __enter__(self) -> Page:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._socket.close()
        self._process.terminate()
        try:
            self._process.wait(timeout=_ENDING)
        except subprocess.TimeoutExpired:  # it waits for a page that is busy
            self._process.kill()
            self._process.wait(timeout=_START)
