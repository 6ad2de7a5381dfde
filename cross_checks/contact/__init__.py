"""Engines with their own contact models, compared by figures: one file for each engine, listed at run time."""

from collections.abc import Sequence
from copy import copy
from functools import cache, partial
from importlib import import_module
from pathlib import Path

from cross_checks import engines
from cross_checks.contact import driven
from cross_checks.contact.request import ContactModel, Request, Translation
from cross_checks.engine import Engine, Refusal
from cross_checks.engines.elsewhere import Elsewhere
from cross_checks.isolation.environments import home_of
from cross_checks.judge.vocabulary import OURS

DRIVEN = ("bullet", "ode", "siconos")  # by a driver, under a Python of their own
ENGINES = ("mujoco", "mjx", "exudyn", "drake", "dart", "newton", *DRIVEN)  # that have a contact model of their own


def model_of(engine: str) -> ContactModel | str:
    """Return the contact model of an engine, or the reason why there is none; ValueError for another name."""
    if engine not in ENGINES:
        raise ValueError(f"engine = {engine!r} has no contact model here; allowed: {', '.join(ENGINES)}")
    if engine in DRIVEN:
        return "not installed" if (home := home_of(engine)) is None else driven.model(engine, home)
    found = next(engines.installed([engine]), None)
    if found is None:
        return "not installed"
    return _model_there(engine, found.home) if isinstance(found, Elsewhere) else _model_here(engine)


@cache
def _model_there(name: str, home: Path) -> ContactModel:
    there = Elsewhere(name, home, _engine_here)
    return ContactModel(there, partial(there.ask, _translation, name), there.ask(_compared, name))


def _model_here(name: str) -> ContactModel:
    return import_module(f"{__name__}.{name}_").MODEL


def _engine_here(name: str) -> Engine:
    return _model_here(name).engine


def _translation(_: object, name: str, request: Request) -> Translation:
    return _model_here(name).translate(request)


def _compared(_: object, name: str) -> tuple[str, ...]:
    return _model_here(name).compared


def own_engine(name: str) -> Engine:
    """Return the engine with its own contact model, or ours; others refuse every scene. Raises EngineMissing."""
    model = model_of(name) if name in ENGINES else f"{name} has no contact model of its own"
    if isinstance(model, ContactModel):
        return model.engine
    engine = copy(engines.get(name))
    vars(engine).update({} if name == OURS else {"refusals": lambda _: [Refusal(model, permanent=False)]})
    return engine


def models(names: Sequence[str] = ENGINES) -> tuple[dict[str, ContactModel], list[str]]:
    """Return the contact models of the engines that are installed, and a sentence for each of the others."""
    known = {name: model_of(name) for name in names}
    absent = [f"{name}: {model}" for name, model in known.items() if isinstance(model, str)]
    return {name: model for name, model in known.items() if isinstance(model, ContactModel)}, absent
