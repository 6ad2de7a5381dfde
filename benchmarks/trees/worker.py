"""Run cases with the packages of one source tree, on command: JSON lines in, JSON lines out.

It is started as a script (python -P) with PYTHONPATH set to the tree, which may be older than this file:
it uses nothing of the tree but the contract of engines.
"""

from __future__ import annotations

import json
import os
import sys
import time
from typing import Any, TextIO


def main() -> None:
    answers = os.fdopen(os.dup(1), "w")  # an engine that prints must not spoil the answers
    os.dup2(2, 1)
    import mbs_ref

    _say(answers, {"tree": os.path.dirname(os.path.dirname(os.path.abspath(mbs_ref.__path__[0] + "/x")))})
    for line in sys.stdin:
        asked = json.loads(line)
        _say(answers, {"climb": climb, "time": timed}[asked.pop("do")](**asked))


def _say(answers: TextIO, data: Any) -> None:
    answers.write(json.dumps(data) + "\n")
    answers.flush()


def climb(scene: str, parameters: dict[str, Any], engine: str, method: str) -> list[dict[str, Any]]:
    """Judge every rung of a method's ladder: settings, error (m), loop time (s)."""
    from cross_checks import engines
    from cross_checks.judge import ladder
    from cross_checks.judge.one_run import evaluate
    from mbs_ref import scenes

    made = scenes.make(scene, **parameters)
    runs = []
    for settings in ladder.rungs(engines.get(engine).method(method), made):
        record = evaluate(made, engine, settings, ladder.grid(made))
        error = None if record.error is None else record.error.value + record.error.uncertainty
        loop_s, kept = record.times.get("loop_s"), record.settings
        runs.append({"settings": kept, "status": record.status, "error": error, "loop_s": loop_s})
        if (loop_s or 0.0) > 1.0:
            break
    return runs


def timed(scene: str, parameters: dict[str, Any], engine: str, settings: dict[str, Any]) -> dict[str, float]:
    """Time one run: the loop (s), and the share of a processor that the process got meanwhile."""
    from cross_checks import engines
    from cross_checks.judge import ladder
    from mbs_ref import scenes
    from mbs_ref.settings import Settings

    made = scenes.make(scene, **parameters)
    chosen, times = Settings(**settings), ladder.grid(made)
    wall, cpu = time.perf_counter(), time.process_time()
    loop_s = engines.get(engine).run(made, chosen, times).timing.loop_s
    return {"loop_s": loop_s, "cpu_share": (time.process_time() - cpu) / (time.perf_counter() - wall)}


if __name__ == "__main__":
    main()
