"""Engines with their own contact models, compared by figures: one file for each engine, listed at run time."""

from importlib import import_module
from pathlib import Path

from cross_checks import engines
from cross_checks.contact.request import ContactModel

ENGINES = ("mujoco", "exudyn", "drake", "dart", "newton")  # that have a contact model of their own


def model_of(engine: str) -> ContactModel | str:
    """Return the contact model of an engine, or the reason why there is none; ValueError for another name."""
    if engine not in ENGINES:
        raise ValueError(f"engine = {engine!r} has no contact model here; allowed: {', '.join(ENGINES)}")
    try:
        engines.get(engine)
    except engines.EngineMissing:
        return "not installed"
    folder = Path(__file__).parent
    if not list(folder.glob(f"{engine}_*")):
        return "its contact parameters are not translated yet"
    return import_module(f"{__name__}.{engine}_").MODEL


def installed() -> dict[str, ContactModel]:
    """Return the contact models of the engines that are installed."""
    models = {name: model_of(name) for name in ENGINES}
    return {name: model for name, model in models.items() if not isinstance(model, str)}
