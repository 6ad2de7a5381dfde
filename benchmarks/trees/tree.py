"""A source tree that runs cases in a process of its own."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any, Self

from benchmarks.trees import worker as tree_worker
from cross_checks.isolation.parent import ONE_THREAD
from cross_checks.prices.timing import Sample


class Tree:
    """The packages found in a folder, alive in a child process. RuntimeError where it does not answer."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()
        if not (self.folder / "mbs_ref" / "__init__.py").is_file():
            raise ValueError(f"{folder} is no source tree: it has no mbs_ref package")
        self._child = subprocess.Popen(
            [sys.executable, "-P", tree_worker.__file__], cwd=self.folder, text=True,
            env=os.environ | ONE_THREAD | {"PYTHONPATH": str(self.folder)},
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        loaded = Path(self._answer()["tree"]).resolve()
        if loaded != self.folder:
            raise RuntimeError(f"the packages of {loaded} were loaded instead of those of {self.folder}")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._child.kill()
        self._child.communicate()

    def climb(self, **case: Any) -> list[dict[str, Any]]:
        """Return settings, status, error (m) and loop time (s) of a method's ladder."""
        return self._ask("climb", case)

    def time(self, **case: Any) -> Sample:
        """Time one run."""
        return Sample(**self._ask("time", case))

    def rate(self, **case: Any) -> float:
        """Return the processor time (ns a body) of a right-hand side."""
        return self._ask("rate", case)["ns_per_body"]

    def _ask(self, what: str, case: dict[str, Any]) -> Any:
        assert self._child.stdin is not None
        self._child.stdin.write(json.dumps({"do": what} | case) + "\n")
        self._child.stdin.flush()
        return self._answer()

    def _answer(self) -> Any:
        assert self._child.stdout is not None
        line = self._child.stdout.readline()
        if not line:
            raise RuntimeError(f"the tree {self.folder} does not run: exit code {self._child.wait()}")
        return json.loads(line)
