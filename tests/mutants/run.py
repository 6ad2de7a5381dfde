"""Write each seeded defect into a copy of the tree, and see whether the tests notice.

    python -m tests.mutants.run [--workers N] [--match TEXT] [--slow] [--minutes M] [--again]

Results are kept in reports/out/mutants.json as they come: a run that was cut short goes on where it stopped, and a
defect is run again when its file, or the tests that watch it, have changed. Exit code 1 where a defect survives
without a reason, or its text is no longer found.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import Queue
from typing import Any

from mbs_ref.files import write_atomic
from mbs_ref.kernels.jit import cache_folder
from tests.mutants.defect import ROOT, Defect, StaleError, apply, every, place
from tests.mutants.watchers import tests_for

LEFT_OUT = (".git", ".venv*", "site", "build", "dist", "*.egg-info")  # of the root
OUT = ROOT / "reports" / "out" / "mutants.json"
LONGEST = 1800.0  # s of one defect; a run that does not end has been noticed
FIRST_FAILURE = re.compile(r"^(?:FAILED|ERROR) (\S+)", re.MULTILINE)


class Copy:
    """A copy of the tree and of the compiled code, in which one defect at a time lives."""

    def __init__(self, folder: Path) -> None:
        self.root, self.cache = folder / "tree", folder / "cache"
        shutil.copytree(ROOT, self.root, ignore=_left_out)
        if cache_folder().is_dir():  # linked, not copied: whoever writes compiled code replaces its files
            shutil.copytree(cache_folder(), self.cache / "mbs-ref" / "compiled", copy_function=_link)

    def judge(self, defect: Defect, slow: bool) -> dict[str, Any]:
        """Return verdict (noticed, survived, stale), the test that noticed, and s."""
        begun = time.monotonic()
        try:
            file = place(defect, self.root)
        except StaleError as error:
            return {"verdict": "stale", "by": str(error), "seconds": 0.0}
        sound = file.read_bytes()
        compiled = self.cache / "mbs-ref" / "compiled"
        before = set(compiled.iterdir()) if compiled.is_dir() else set()
        try:
            apply(defect, self.root)
            verdict, by = self._tested(str(file.relative_to(self.root)), slow)
        finally:
            file.write_bytes(sound)
            for folder in set(compiled.iterdir()) - before if compiled.is_dir() else ():
                shutil.rmtree(folder, ignore_errors=True)  # compiled of the defect
        return {"verdict": verdict, "by": by, "seconds": round(time.monotonic() - begun, 1)}

    def _tested(self, file: str, slow: bool) -> tuple[str, str]:
        """Run the tests that watch a file, each place of them until one fails."""
        for markers in ("not slow", "slow") if slow else ("not slow",):
            for tests in tests_for(file):
                code, output = self._pytest(tests, markers)
                if code is None:
                    return "noticed", f"{tests} does not end within {LONGEST:g} s"
                if code in (3, 4):  # pytest's own error, or tests that are not there
                    raise RuntimeError(f"{tests} could not be run: {output.strip()[-500:]}")
                if code not in (0, 5):  # 5: no test was selected
                    failure = FIRST_FAILURE.search(output)
                    when = "make test" if markers == "not slow" else "make nightly"
                    return "noticed", f"{when}: {failure.group(1) if failure else output.strip().splitlines()[-1]}"
        return "survived", ""

    def _pytest(self, tests: str, markers: str) -> tuple[int | None, str]:
        environment = os.environ | {"PYTHONPATH": str(self.root), "MBS_REF_CACHE": str(self.cache),
                                    "PYTHONDONTWRITEBYTECODE": "1"}  # fmt: skip
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-m", markers, tests]
        shown: Any = {"capture_output": True, "text": True, "timeout": LONGEST}
        try:
            done = subprocess.run(command, cwd=self.root, env=environment, **shown)
        except subprocess.TimeoutExpired:
            return None, ""
        return done.returncode, done.stdout + done.stderr


def _left_out(folder: str, names: list[str]) -> set[str]:
    """Name what tests do not read: of history, environments and results; folders of sources may have such names."""
    made = shutil.ignore_patterns("__pycache__", "out", ".*_cache")(folder, names)
    return made | (shutil.ignore_patterns(*LEFT_OUT)(folder, names) if Path(folder) == ROOT else set())


def _link(source: str, target: str) -> None:
    try:
        os.link(source, target)
    except OSError:
        shutil.copy2(source, target)


def state(defect: Defect) -> str:
    """Return a digest of what the verdict on a defect depends on: its file and the tests that watch it."""
    digest = hashlib.sha256(defect.name.encode())
    files = [ROOT / defect.file]
    for tests in tests_for(defect.file):
        files += sorted((ROOT / tests).rglob("*.py")) if (ROOT / tests).is_dir() else [ROOT / tests]
    for file in files:
        digest.update(file.read_bytes() if file.is_file() else b"")
    return digest.hexdigest()[:16]


def run(defects: list[Defect], workers: int, slow: bool, minutes: float, out: Path, again: bool) -> dict[str, Any]:
    """Judge defects, keeping each verdict in `out` as it comes; return all verdicts by the defects' names."""
    known: dict[str, Any] = json.loads(out.read_text())["defects"] if out.is_file() else {}
    current = {defect.name: state(defect) for defect in defects}
    waiting = [d for d in defects if again or known.get(d.name, {}).get("state") != current[d.name]]
    end = time.monotonic() + 60.0 * minutes
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder, ThreadPoolExecutor(workers) as pool:
        copies: Queue[Copy] = Queue()
        for k in range(workers):
            copies.put(Copy(Path(folder) / str(k)))

        def judged(defect: Defect) -> None:
            if time.monotonic() > end:
                return
            copy = copies.get()
            try:
                found = copy.judge(defect, slow)
            finally:
                copies.put(copy)
            known[defect.name] = {**vars(defect), **found, "state": current[defect.name]}
            out.parent.mkdir(parents=True, exist_ok=True)
            write_atomic(out, (json.dumps(summary(defects, known) | {"defects": known}, indent=1) + "\n").encode())
            what = f"{found['verdict']:9} {found['seconds']:7.1f} s  {defect.file}: {defect.breaks}"
            print(f"{what}  {found['by']}", flush=True)

        list(pool.map(judged, waiting))
    return known


def summary(defects: list[Defect], known: dict[str, Any]) -> dict[str, Any]:
    """Return how many defects there are, and how many were noticed, survived, are stale, or excused by a reason."""
    verdicts = [known[d.name]["verdict"] for d in defects if d.name in known]
    excused = [d for d in defects if d.reason and known.get(d.name, {}).get("verdict") == "survived"]
    counted = {word: verdicts.count(word) for word in ("noticed", "survived", "stale")}
    score = round(counted["noticed"] / max(1, counted["noticed"] + counted["survived"]), 4)
    return {"total": len(defects), "judged": len(verdicts), **counted, "excused": len(excused), "score": score}


def main() -> int:
    parser = argparse.ArgumentParser(description="Seeded defects: do the tests notice?")
    parser.add_argument("--workers", type=int, default=max(1, (os.cpu_count() or 2) - 1))
    parser.add_argument("--match", default="", help="only defects whose file or words hold this text")
    parser.add_argument("--slow", action="store_true", help="ask the slow tests too where the quick ones see nothing")
    parser.add_argument("--minutes", type=float, default=1e6, help="begin no other defect after so many minutes")
    parser.add_argument("--again", action="store_true", help="judge afresh what is known already")
    parser.add_argument("--out", type=Path, default=OUT)
    asked = parser.parse_args()
    chosen = [d for d in every() if asked.match in f"{d.file} {d.breaks}"]
    known = run(chosen, asked.workers, asked.slow, asked.minutes, asked.out, asked.again)
    found = summary(chosen, known)
    print(json.dumps(found))
    for defect in chosen:
        verdict = known.get(defect.name, {}).get("verdict")
        if verdict in ("survived", "stale"):
            print(f"{verdict}: {defect.file}: {defect.old!r} -> {defect.new!r}: {defect.breaks}. {defect.reason}")
    return int(found["survived"] > found["excused"] or found["stale"] > 0)


if __name__ == "__main__":
    sys.exit(main())
