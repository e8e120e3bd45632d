"""A headless Chromium that benches drive, over a pipe: what its page says, logs and asks for."""

from __future__ import annotations

import base64
import contextlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

_KEYS = {"Tab": 9, "Enter": 13, "ArrowDown": 40, "ArrowUp": 38, " ": 32}


class Browser:
    """One page. `console`: what it wrote, threw or was refused; `requests`: addresses that it asked for."""

    def __init__(self) -> None:
        names = ("chromium", "chromium-browser", "google-chrome")
        binary = next((path for name in names if (path := shutil.which(name))), None)
        if binary is None:
            print("no Chromium on this machine: scripts/need chromium chromium", file=sys.stderr)
            raise SystemExit(2)
        self.console: list[str] = []
        self.requests: list[str] = []
        self._folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        self._number = 0
        self._rest = b""
        to_read, self._write = os.pipe()
        self._read, to_write = os.pipe()

        def as_three_and_four() -> None:
            high = [os.dup(to_read), os.dup(to_write)]  # neither may be 3 or 4 when the other takes its place
            os.dup2(high[0], 3)
            os.dup2(high[1], 4)

        words = "--headless=new --no-sandbox --remote-debugging-pipe --hide-scrollbars --no-first-run"
        words += " --use-angle=swiftshader --enable-unsafe-swiftshader"  # pictures in space, without a graphics card
        command = [binary, *words.split(), f"--user-data-dir={self._folder.name}", "about:blank"]
        self._process = subprocess.Popen(
            command, pass_fds=(3, 4), preexec_fn=as_three_and_four, stderr=subprocess.DEVNULL
        )
        os.close(to_read)
        os.close(to_write)
        target = next(t for t in self._call("Target.getTargets")["targetInfos"] if t["type"] == "page")
        attached = {"targetId": target["targetId"], "flatten": True}
        self._session: str | None = self._call("Target.attachToTarget", attached)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network", "DOM"):
            self.call(f"{domain}.enable")

    def __enter__(self) -> Browser:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._process.terminate()
        self._process.wait(10)
        self._folder.cleanup()

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        return self._call(method, parameters, self._session)

    def _call(
        self, method: str, parameters: Mapping[str, Any] | None = None, session: str | None = None
    ) -> dict[str, Any]:
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters or {}}
        os.write(
            self._write,
            json.dumps({**message, **({"sessionId": session} if session else {})}).encode() + b"\0",
        )
        while True:
            told = self._next()
            if told.get("id") == self._number:
                if "error" in told:
                    raise RuntimeError(f"{method}: {told['error']['message']}")
                result: dict[str, Any] = told["result"]
                return result

    def _next(self) -> dict[str, Any]:
        while b"\0" not in self._rest:
            more = os.read(self._read, 1 << 20)
            if not more:
                raise RuntimeError("the browser has ended")
            self._rest += more
        text, _, self._rest = self._rest.partition(b"\0")
        told: dict[str, Any] = json.loads(text)
        self._note(told)
        return told

    def _note(self, told: dict[str, Any]) -> None:
        what, given = told.get("method"), told.get("params", {})
        if what == "Network.requestWillBeSent":
            self.requests.append(given["request"]["url"])
        elif what == "Runtime.exceptionThrown":
            details = given["exceptionDetails"]
            self.console.append(details.get("exception", {}).get("description", details["text"]))
        elif what == "Runtime.consoleAPICalled":
            self.console.append(" ".join(str(one.get("value", "")) for one in given["args"]))
        elif what == "Log.entryAdded" and given["entry"]["level"] == "error":
            self.console.append(f"{given['entry']['text']} {given['entry'].get('url', '')}")

    def run(self, script: str) -> Any:
        """The value of an expression in the page, awaited. Raises RuntimeError for what it throws."""
        told = self.call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in told:
            raise RuntimeError(str(told["exceptionDetails"]))
        return told["result"].get("value")

    def until(self, script: str, seconds: float = 60.0) -> Any:
        """The first value of an expression that is true; one that throws is not there yet. Raises TimeoutError."""
        end = time.monotonic() + seconds
        while True:
            with contextlib.suppress(RuntimeError):
                if value := self.run(script):
                    return value
            if time.monotonic() > end:
                raise TimeoutError(script)
            time.sleep(0.02)

    def open(self, address: str) -> None:
        self.call("Page.navigate", url=address)

    def size(self, width: int, height: int) -> None:
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )

    def medium(self, kind: str = "screen", scheme: str = "light") -> None:
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        self.call("Emulation.setEmulatedMedia", media=kind, features=features)

    def key(self, name: str) -> None:
        """One that is pressed and let go."""
        text = {"text": "\r"} if name == "Enter" else {"text": " "} if name == " " else {}
        code = {
            "key": name,
            "windowsVirtualKeyCode": _KEYS.get(name, 0),
            "code": "Space" if name == " " else name,
        }
        self.call("Input.dispatchKeyEvent", type="keyDown", **code, **text)
        self.call("Input.dispatchKeyEvent", type="keyUp", **code)

    def drop(self, files: Sequence[Path], x: int = 200, y: int = 200) -> None:
        """Files that are dragged in and dropped."""
        data = {"items": [], "files": [str(file) for file in files], "dragOperationsMask": 1}
        for kind in ("dragEnter", "dragOver", "drop"):
            self.call("Input.dispatchDragEvent", type=kind, x=x, y=y, data=data)

    def picture(self, file: Path, whole: bool = False) -> None:
        told = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        file.write_bytes(base64.b64decode(told["data"]))
