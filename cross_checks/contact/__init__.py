"""Engines with their own contact models, compared by figures: one file for each engine, listed at run time."""

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

from cross_checks import engines
from cross_checks.contact.request import ContactModel
from cross_checks.engine import Engine

ENGINES = ("mujoco", "exudyn", "drake", "dart", "newton")  # that have a contact model of their own


def model_of(engine: str) -> ContactModel | str:
    """Return the contact model of an engine, or the reason why there is none; ValueError for another name."""
    if engine not in ENGINES:
        raise ValueError(f"engine = {engine!r} has no contact model here; allowed: {', '.join(ENGINES)}")
    if not any(engines.installed([engine])):
        return "not installed"
    if not Path(__file__).with_name(f"{engine}_.py").exists():
        return "its contact parameters are not translated yet"
    return import_module(f"{__name__}.{engine}_").MODEL


def own_engine(name: str) -> Engine:
    """Return the engine with its own contact model where it has one, else as registered; raises EngineMissing."""
    model = model_of(name) if name in ENGINES else ""
    return engines.get(name) if isinstance(model, str) else model.engine


def models(names: Sequence[str] = ENGINES) -> tuple[dict[str, ContactModel], list[str]]:
    """Return the contact models of the engines that are installed, and a sentence for each of the others."""
    known = {name: model_of(name) for name in names}
    absent = [f"{name}: {model}" for name, model in known.items() if isinstance(model, str)]
    return {name: model for name, model in known.items() if isinstance(model, ContactModel)}, absent
