"""Environments of engines: one whose packages do not go with ours lives in a virtual environment of its own.

A note beside the others, NAME.json in the user's data folder, says where it is. Runs go there through the same child
process as all isolated calls, with that environment's Python.
"""

import json
import os
import site
import subprocess
import sys
import sysconfig
import venv
from collections.abc import Sequence
from pathlib import Path

from mbs_ref.files import write_atomic

FOLDER = "MBS_REF_ENVIRONMENTS"  # an environment variable: where the notes are
INSIDE = "MBS_REF_INSIDE"  # set within an engine's own environment: the engine that is imported there
PROJECT = Path(__file__).parents[2]
BENEATH = "beneath.pth"  # in an environment on top of this one: packages of this one are seen below its own


PINS = Path(__file__).parent / "pins"  # NAME.txt: the exact releases of an engine's environment


class NotMade(RuntimeError):
    """An environment could not be created; the message contains pip's."""


def folder() -> Path:
    """Return the folder of notes and environments: MBS_REF_ENVIRONMENTS, or the user's data folder."""
    named = os.environ.get(FOLDER)
    data = Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share")
    return Path(named) if named else data / "mbs-ref" / "engines"


def home_of(name: str) -> Path | None:
    """Return the environment that the engine lives in; None where that is this one."""
    note = folder() / f"{name}.json"
    if os.environ.get(INSIDE) == name or not note.is_file():
        return None
    return Path(json.loads(note.read_text(encoding="utf-8"))["environment"])


def homes() -> dict[str, Path]:
    """Return the environments by engine."""
    found = {note.stem: home_of(note.stem) for note in sorted(folder().glob("*.json"))}
    return {name: home for name, home in found.items() if home is not None}


def python_of(home: Path) -> Path:
    """Return the interpreter of an environment."""
    return home / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")


def surroundings(name: str) -> dict[str, str]:
    """Return the variables that a child process of an engine's environment needs: our sources, not our packages."""
    packages = {Path(sysconfig.get_path(kind)) for kind in ("purelib", "platlib")}
    sources = "" if PROJECT in packages else str(PROJECT)  # an installed project is installed there, too
    return {"PYTHONPATH": sources, INSIDE: name}


def make(name: str, requirements: Sequence[str], home: Path | None = None, *, over: bool = False) -> Path:
    """Create the engine's environment, install the requirements in it, store its path, and return it.

    `over` lets it see this environment's packages below its own, so that only what differs is installed.
    NotMade where pip fails; nothing is noted then.
    """
    where = (home or folder() / name).absolute()
    venv.EnvBuilder(clear=where.is_dir() and python_of(where).exists(), symlinks=os.name != "nt").create(where)
    if over:
        beneath = [*site.getsitepackages(), sysconfig.get_path("purelib"), sysconfig.get_path("platlib")]
        lines = [f"import site; site.addsitedir({path!r})" for path in dict.fromkeys(beneath)]
        (_site_of(where) / BENEATH).write_text("\n".join(lines) + "\n", encoding="utf-8")
    if requirements:
        _install(python_of(where), requirements, pins_of(name))
    folder().mkdir(parents=True, exist_ok=True)
    note = {"environment": str(where), "requirements": list(requirements), "over": over}
    write_atomic(folder() / f"{name}.json", json.dumps(note, indent=2).encode())
    return where


def forget(name: str) -> Path | None:
    """Delete the stored path of an engine's environment and return it; the environment remains."""
    home = home_of(name)
    (folder() / f"{name}.json").unlink(missing_ok=True)
    return home


def pins_of(name: str) -> Path | None:
    """Return the file of exact releases that the engine's environment consists of; None where there is none."""
    file = PINS / f"{name}.txt"
    return file if file.is_file() else None


def _site_of(home: Path) -> Path:
    scheme = {"base": str(home), "platbase": str(home)}
    return Path(sysconfig.get_path("purelib", "venv", scheme))


def _install(python: Path, requirements: Sequence[str], pins: Path | None) -> None:
    command = [sys.executable, "-m", "pip", "--python", str(python), "install", "--disable-pip-version-check", "-q"]
    held = [] if pins is None else ["--constraint", str(pins)]
    done = subprocess.run([*command, *held, *requirements], capture_output=True, text=True, check=False)
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if line.strip()]
        raise NotMade(f"pip could not install {', '.join(requirements)}: {lines[-1] if lines else 'it gave no reason'}")
