"""A scene as MJCF with all digits, which MuJoCo's own writer rounds to six, or as a script that runs in MuJoCo alone.

It is taken from the model that the adapter has compiled: moments of inertia along their principal axes, and the start
in a keyframe. Before it is given away it is compiled again and compared, number by number.
"""

from collections.abc import Iterator
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from cross_checks.linkage.links import linkage_of
from cross_checks.writers.form import Form, Job, NotWritable, job_of, refuse_shared
from cross_checks.writers.script import script, turns_of
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings

# MuJoCo's numbers in the words of its files
INTEGRATORS = ("Euler", "RK4", "implicit", "implicitfast")
OPTIONS = (
    "timestep", "tolerance", "ls_tolerance", "iterations", "ls_iterations", "noslip_iterations", "impratio", "gravity",
    "wind", "density", "viscosity",
)  # fmt: skip
CONES, JACOBIANS, SOLVERS = ("pyramidal", "elliptic"), ("dense", "sparse", "auto"), ("PGS", "CG", "Newton")
JOINTS, GEOMS = ("free", "ball", "slide", "hinge"), {0: "plane", 2: "sphere"}
DISABLED, ENABLED = {16: "contact", 512: "warmstart"}, {32: "diagexact"}
NOTHING_TOUCHES = {"mass": "0", "contype": "0", "conaffinity": "0"}  # but pairs that are listed
CONNECT, WELD, TENDON = 0, 1, 3
WRAPPED_JOINT, WRAPPED_SITE = 1, 3
BY_TENDON, BY_SITE = 3, 4
SAME = 1e-13  # of an array's largest number: MuJoCo normalises quaternions and axes again


def mujoco_job(scene: Scene, settings: Settings) -> Job:
    """Return what MuJoCo's adapter would run; loads that reach it through Python are refused by name."""
    job = job_of(scene, settings, "mujoco")
    if job.built.act is not None:
        refuse_shared(job)
    return job


def write_mjcf(scene: Scene, settings: Settings) -> str:
    """Return the scene as an MJCF file, with the options of the run; its keyframe `start` is the state at t = 0."""
    return mjcf_of(mujoco_job(scene, settings))


def write_mujoco(scene: Scene, settings: Settings) -> str:
    """Return the script: the model as MJCF with all its digits, and the loop in C."""
    job, start = mujoco_job(scene, settings), linkage_of(scene).theta.tolist()
    return script(job, "mujoco and numpy", model=mjcf_of(job), turns=turns_of(scene), start=start)


def mjcf_of(job: Job) -> str:
    """Return the adapter's model as MJCF."""
    root = _Written(job.built.model, job.built.data, job.scene.name).root()
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode") + "\n"
    different = sorted(_differences(job.built.model, type(job.built.model).from_xml_string(text)))
    if different:
        raise NotWritable(f"{job.scene.name} as MJCF reads back with other {', '.join(different)}")
    return text


def _differences(one: Any, other: Any) -> Iterator[str]:
    """Yield the arrays and options of a model that are not the same in another."""
    for of, pair in (("", (one, other)), ("opt.", (one.opt, other.opt))):
        for name in dir(pair[0]):
            a, b = (getattr(of_model, name) for of_model in pair)
            if isinstance(a, np.ndarray | float | int) and not name.startswith(("_", "names", "name_", "key_", "nkey")):
                a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
                if name in SIZES:
                    continue
                if a.shape != b.shape or np.any(np.abs(a - b) > SAME * np.max(np.abs(a), initial=1.0)):
                    yield of + name


SIZES = ("nbuffer", "nnames", "nnames_map", "narena", "signature", "npaths")  # of memory, names and the keyframe


class _Written:
    """An MJCF tree of a compiled model."""

    def __init__(self, model: Any, data: Any, name: str) -> None:
        self.model, self.data, self.name = model, data, name

    def root(self) -> Element:
        root = Element("mujoco", model=self.name)
        SubElement(root, "compiler", angle="radian", autolimits="false", inertiafromgeom="false")
        o = self.model.opt
        words = {"integrator": INTEGRATORS, "cone": CONES, "jacobian": JACOBIANS, "solver": SOLVERS}
        option = SubElement(root, "option", {name: _text(getattr(o, name)) for name in OPTIONS})
        option.attrib |= {name: allowed[getattr(o, name)] for name, allowed in words.items()}
        off = {word: "disable" for bit, word in DISABLED.items() if o.disableflags & bit}
        on = {word: "enable" for bit, word in ENABLED.items() if o.enableflags & bit}
        SubElement(option, "flag", off | on)
        world = SubElement(root, "worldbody")
        self._in_body(world, 0)
        self._bodies(world, 0)
        self._contacts(SubElement(root, "contact"))
        self._equalities(SubElement(root, "equality"))
        self._tendons(SubElement(root, "tendon"))
        self._actuators(SubElement(root, "actuator"))
        start = SubElement(SubElement(root, "keyframe"), "key", name="start")
        if self.model.nv:
            start.attrib |= {"qpos": _text(self.data.qpos), "qvel": _text(self.data.qvel)}
        for empty in [part for part in root if not len(part) and not part.attrib]:
            root.remove(empty)
        return root

    def _texts(self, group: str, k: int, *names: str, **others: str) -> dict[str, str]:
        """Return the entries k of the model's arrays as attributes: pos is of geom_pos; others have another name."""
        arrays = {name: name for name in names} | others
        return {name: _text(getattr(self.model, f"{group}_{array}")[k]) for name, array in arrays.items()}

    def _bodies(self, parent: Element, number: int) -> None:
        m = self.model
        for b in [b for b in range(1, m.nbody) if m.body_parentid[b] == number]:
            body = SubElement(parent, "body", {"name": m.body(b).name, **self._texts("body", b, "pos", "quat")})
            central = {"pos": "ipos", "quat": "iquat", "mass": "mass", "diaginertia": "inertia"}
            SubElement(body, "inertial", self._texts("body", b, **central))
            self._joints(body, b)
            self._in_body(body, b)
            self._bodies(body, b)

    def _joints(self, body: Element, b: int) -> None:
        m = self.model
        first = m.body_jntadr[b]
        for j in range(first, first + m.body_jntnum[b]):
            kind = JOINTS[m.jnt_type[j]]
            joint = SubElement(body, "joint", name=_name(m.joint(j)), type=kind)
            if kind == "free":
                continue
            joint.attrib |= self._texts("jnt", j, "pos")
            if kind != "ball":
                joint.attrib |= self._texts("jnt", j, "axis", "stiffness")
                joint.set("damping", _text(m.dof_damping[m.jnt_dofadr[j]]))
                joint.set("springref", _text(m.qpos_spring[m.jnt_qposadr[j]]))

    def _in_body(self, body: Element, b: int) -> None:
        """Write the shapes and sites that a body, or the world, carries."""
        m = self.model
        for g in np.flatnonzero(m.geom_bodyid == b):
            geom = SubElement(body, "geom", name=_name(m.geom(g)), type=GEOMS[m.geom_type[g]])
            geom.attrib |= self._texts("geom", int(g), "size", "pos", "quat") | NOTHING_TOUCHES
        for s in np.flatnonzero(m.site_bodyid == b):
            SubElement(body, "site", {"name": _name(m.site(s)), **self._texts("site", int(s), "pos", "quat")})

    def _contacts(self, parent: Element) -> None:
        m = self.model
        for p in range(m.npair):
            geoms = {f"geom{k}": _name(m.geom(ends[p])) for k, ends in ((1, m.pair_geom1), (2, m.pair_geom2))}
            pair = SubElement(parent, "pair", geoms, name=_name(m.pair(p)), condim=str(m.pair_dim[p]))
            pair.attrib |= self._texts("pair", p, "margin", "gap", "solref", "solimp", "friction")

    def _equalities(self, parent: Element) -> None:
        m = self.model
        for e in range(m.neq):
            numbers, one, two = m.eq_data[e], m.eq_obj1id[e], m.eq_obj2id[e]
            shared = {"name": _name(m.equality(e)), **self._texts("eq", e, "solref", "solimp")}
            if m.eq_type[e] == TENDON:
                SubElement(parent, "tendon", shared, tendon1=_name(m.tendon(one)), polycoef=_text(numbers[:5]))
                continue
            ends = {"body1": m.body(one).name, "body2": m.body(two).name, "anchor": _text(numbers[:3])}
            if m.eq_type[e] == CONNECT:
                SubElement(parent, "connect", shared, **ends)
            elif m.eq_type[e] == WELD:
                turn = {"relpose": _text(numbers[3:10]), "torquescale": _text(numbers[10])}
                SubElement(parent, "weld", shared, **ends, **turn)

    def _tendons(self, parent: Element) -> None:
        m = self.model
        for t in range(m.ntendon):
            first = m.tendon_adr[t]
            wraps = range(first, first + m.tendon_num[t])
            fixed = m.wrap_type[first] == WRAPPED_JOINT
            tendon = SubElement(parent, "fixed" if fixed else "spatial", name=_name(m.tendon(t)))
            tendon.attrib |= self._texts("tendon", t, "stiffness", "damping", springlength="lengthspring")
            for w in wraps:
                if m.wrap_type[w] == WRAPPED_JOINT:
                    SubElement(tendon, "joint", joint=_name(m.joint(m.wrap_objid[w])), coef=_text(m.wrap_prm[w]))
                elif m.wrap_type[w] == WRAPPED_SITE:
                    SubElement(tendon, "site", site=_name(m.site(m.wrap_objid[w])))

    def _actuators(self, parent: Element) -> None:
        m = self.model
        for a in range(m.nu):
            one, two = m.actuator_trnid[a]
            target = (
                {"tendon": _name(m.tendon(one))} if m.actuator_trntype[a] == BY_TENDON else {"site": _name(m.site(one))}
            )
            if m.actuator_trntype[a] == BY_SITE and two >= 0:
                target["refsite"] = _name(m.site(two))
            SubElement(
                parent, "general", target, name=_name(m.actuator(a)), gear=_text(m.actuator_gear[a]), gaintype="fixed",
                gainprm=_text(m.actuator_gainprm[a][:3]), biastype="affine", biasprm=_text(m.actuator_biasprm[a][:3]),
            )  # fmt: skip


def _name(part: Any) -> str:
    """Return a part's name as names of scenes are, so that the file reads back."""
    return part.name.replace("/", ".")


def _text(numbers: Any) -> str:
    """Return numbers with all their digits."""
    return " ".join(repr(float(x)) if isinstance(x, float) else str(int(x)) for x in np.atleast_1d(numbers).tolist())


FORMS = (
    Form("mjcf", ".xml", "a model file of MuJoCo", write_mjcf),
    Form("mujoco", ".py", "a script that runs in MuJoCo alone", write_mujoco),
)
