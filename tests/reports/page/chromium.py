"""Chromium over its debugging pipe: load a page at a width, ask it questions, and receive what it complains of."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

from reports.page.build import browser

COMPLAINTS = ("Runtime.exceptionThrown", "Log.entryAdded")


class Chromium:
    """One page of a browser without a window."""

    def __init__(self, profile: Path) -> None:
        ours_in, theirs_out = os.pipe()
        theirs_in, ours_out = os.pipe()
        options = f"--headless --no-sandbox --remote-debugging-pipe --user-data-dir={profile} about:blank"
        command = f'exec "{browser()}" {options} 3<&{theirs_in} 4>&{theirs_out}'
        self._process = subprocess.Popen(
            ["bash", "-c", command], pass_fds=(theirs_in, theirs_out), stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(theirs_in)
        os.close(theirs_out)
        self._in, self._out = os.fdopen(ours_in, "rb", 0), os.fdopen(ours_out, "wb", 0)
        self._rest, self._number, self._session = b"", 0, None
        self.complaints: list[str] = []
        target = self("Target.createTarget", url="about:blank")["targetId"]
        self._session = self("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self(f"{domain}.enable")

    def __call__(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a command; return its result, and store the complaints that come before it."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        message |= {"sessionId": self._session} if self._session else {}
        self._out.write(json.dumps(message).encode() + b"\0")
        while True:
            answer = self._read()
            if answer.get("id") == self._number:
                assert "error" not in answer, answer
                return answer["result"]

    def _read(self) -> dict[str, Any]:
        while b"\0" not in self._rest:
            part = self._in.read(1 << 16)
            assert part, "the browser ended"
            self._rest += part
        line, self._rest = self._rest.split(b"\0", 1)
        answer = json.loads(line)
        method = answer.get("method")
        logged = answer.get("params", {})
        if method in COMPLAINTS or (method == "Runtime.consoleAPICalled" and logged["type"] in ("error", "warning")):
            self.complaints.append(json.dumps(logged)[:500])
        return answer

    def open(self, address: str, width: int) -> None:
        """Load a page at a width (px), and wait until it is there."""
        self("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=width < 600)
        self("Page.navigate", url=address)
        self.ask("new Promise(next => document.readyState === 'complete' ? next() : addEventListener('load', next))")

    def ask(self, expression: str) -> Any:
        """Return the value of an expression in the page, awaited where it is a promise."""
        result = self("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in result, result
        return result["result"].get("value")

    def close(self) -> None:
        """End the browser."""
        self._session = None
        self("Browser.close")
        self._process.wait(timeout=30)
        self._in.close()
        self._out.close()
