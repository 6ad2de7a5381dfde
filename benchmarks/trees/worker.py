"""Run cases with the packages of one source tree, on command: JSON lines in, JSON lines out.

It is started as a script (python -P) with PYTHONPATH set to the tree, which may be older than this file:
it uses nothing of the tree but the contract of engines, and for single right-hand sides the questions that cores
answer.
"""

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
        wanted = json.loads(line)
        _say(answers, {"climb": climb, "time": timed, "rate": rate}[wanted.pop("do")](**wanted))


def _say(answers: TextIO, data: Any) -> None:
    answers.write(json.dumps(data) + "\n")
    answers.flush()


def climb(scene: str, parameters: dict[str, Any], engine: str, method: str) -> list[dict[str, Any]]:
    """Judge every rung of a method's ladder: settings, error (of the scene), loop time (s)."""
    from cross_checks import engines
    from cross_checks.judge import ladder
    from cross_checks.judge.one_run import evaluate
    from mbs_ref import scenes

    built = scenes.make(scene, **parameters)
    runs = []
    for settings in ladder.rungs(engines.get(engine).method(method), built):
        record = evaluate(built, engine, settings, ladder.grid(built))
        error = None if record.error is None else record.error.value + record.error.uncertainty
        loop_s, stored = record.times.get("loop_s"), record.settings
        runs.append({"settings": stored, "status": record.status, "error": error, "loop_s": loop_s})
        if (loop_s or 0.0) > 1.0:
            break
    return runs


def timed(scene: str, parameters: dict[str, Any], engine: str, settings: dict[str, Any]) -> dict[str, float]:
    """Time one run: the loop (s), and the share of a processor that the process got meanwhile."""
    from cross_checks import engines
    from cross_checks.judge import ladder
    from mbs_ref import Settings, scenes

    built = scenes.make(scene, **parameters)
    chosen, times = Settings(**settings), ladder.grid(built)
    wall, cpu = time.perf_counter(), time.process_time()
    loop_s = engines.get(engine).run(built, chosen, times).timing.loop_s
    return {"loop_s": loop_s, "cpu_share": (time.process_time() - cpu) / (time.perf_counter() - wall)}


def rate(scene: str, parameters: dict[str, Any], seconds: float) -> dict[str, float]:
    """Return the processor time (ns a body) of a right-hand side, from about so many seconds of them."""
    from mbs_ref import scenes

    if (scene, str(parameters)) not in _rated:
        _rated[scene, str(parameters)] = right_hand_sides(scenes.make(scene, **parameters))
    run, bodies = _rated[scene, str(parameters)]
    count, spent = 1, 0.0
    while spent < 0.1 * seconds:
        count *= 4
        start = time.process_time()
        run(count)
        spent = time.process_time() - start
    count = max(1, int(count * seconds / spent))
    start = time.process_time()
    run(count)
    return {"ns_per_body": (time.process_time() - start) / count / bodies * 1e9}


_rated: dict[tuple[str, str], Any] = {}


def right_hand_sides(scene: Any) -> tuple[Any, int]:
    """Return a function of how many right-hand sides to evaluate at the start, and the number of bodies."""
    from mbs_ref.cores.choice import compile_scene
    from mbs_ref.kernels.border import questions
    from mbs_ref.kernels.jit import jit

    @jit
    def repeat(model, work, y, dy, count):
        for _ in range(count):
            questions.derivative(model, work, 0.0, y, dy)

    system = compile_scene(scene)
    system.set_mode_time(0.0)
    y = system.initial_state()
    dy = y.copy()
    return lambda count: repeat(system.model, system.work, y, dy, count), len(scene.bodies)


if __name__ == "__main__":
    main()
