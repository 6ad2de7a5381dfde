"""mbs-ref compile: kernels are compiled once for each change of their sources."""

from __future__ import annotations

from click.testing import CliRunner

from cross_checks.records.store import Store
from reports.commands.engines.compile import command
from reports.facts import compiling


def test_what_is_compiled_is_not_compiled_again(monkeypatch, tmp_path):
    asked = []

    def each(wanted, work):
        for one in wanted:
            yield one, work(lambda do, one=one: asked.append(one.name), one)

    monkeypatch.setattr(compiling, "each", each)
    arguments = ["--store", str(tmp_path / "runs.sqlite")]
    for _ in range(2):
        done = CliRunner().invoke(command, arguments)
        assert done.exit_code == 0, done.output
    programs = [engine.name for engine in compiling.engines.installed() if engine.compiles]
    assert asked == [f"compiling {name}" for name in (*compiling.CORES, compiling.LANES, *programs)]
    with Store(tmp_path / "runs.sqlite") as kept:
        compiling.compile_kernels(kept, lambda *_: None)  # as a report does
    assert len(asked) == len(compiling.CORES) + 1 + len(programs)


def test_every_method_runs_on_some_core():
    from cross_checks import engines
    from mbs_ref import scenes

    solver = engines.get(compiling.SOLVER)
    made = [scenes.make(scene) for scene, _, every_method in compiling.CORES.values() if every_method]
    assert all(any(not solver.method_refusals(scene, method) for scene in made) for method in solver.methods())
