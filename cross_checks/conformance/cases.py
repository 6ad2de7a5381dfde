"""The runs by which symmetry and repeatability are tested: each method of each engine on a scene."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from cross_checks import engines
from cross_checks.engine import Engine, Method
from mbs_ref import Scene, Settings, scenes
from mbs_ref.files import package_data

STEP = 1e-3  # s, in the laboratory
SKY_STEPS = 2000  # of a fixed step in the sky
LOOSER = 20.0  # than a method's tightest tolerance: a tenth of the tolerance is used, too


class Case(NamedTuple):
    """One method on one scene."""

    engine: str
    method: str
    scene: str
    parameters: dict[str, Any]
    settings: Settings

    @property
    def name(self) -> str:
        words = [self.scene, *(str(value) for value in self.parameters.values())]
        return f"{self.engine}-{self.method}-{'-'.join(words)}"

    @property
    def setting(self) -> str:
        settings = self.settings
        return f"step {settings.step:.3g} s" if settings.step else f"rtol {settings.rtol:.3g}"

    def built(self) -> Scene:
        return scenes.make(self.scene, **self.parameters)


Placed = tuple[str, dict[str, Any], float | None]  # scene, parameters, end (s) or its own
STATED = package_data(__name__, "cases.toml")
LABORATORY, SKY, RELATIVE, BLAS = (
    tuple((one["scene"], one.get("parameters", {}), one.get("t_end")) for one in STATED[group])
    for group in ("laboratory", "sky", "relative", "blas")
)


def cases(names: list[str], more: tuple[Placed, ...] = ()) -> Iterator[Case]:
    """Yield every method of these engines with every scene that it takes, `more` too; a missing engine has none."""
    for engine in engines.installed(names):
        for method in engine.methods():
            yield from _of(engine, method, more)


def _of(engine: Engine, method: Method, more: tuple[Placed, ...]) -> Iterator[Case]:
    ours = engine.name == "mbs_ref"
    for placed in (*LABORATORY, *SKY, *more, *(RELATIVE if ours and method.name == "gauss" else ())):
        scene, parameters, t_end = placed
        built = scenes.make(scene, **parameters)
        if not engine.refusal(built, method):
            t_end = t_end or built.duration
            yield Case(engine.name, method.name, scene, parameters, _settings(method, placed, t_end))


def _settings(method: Method, placed: Placed, t_end: float) -> Settings:
    if method.kind == "fixed":
        step = t_end / SKY_STEPS if placed in SKY else STEP
        return Settings(method=method.name, t_end=t_end, step=step, estimate="off")
    return Settings(method=method.name, t_end=t_end, rtol=LOOSER * method.ladder[-1], estimate="off")
