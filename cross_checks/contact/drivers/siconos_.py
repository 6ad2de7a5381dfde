"""Siconos: impacts by Newton's law and Coulomb's friction, in Moreau and Jean's time stepping of velocities."""

import sys

import contacts
import numpy as np
from siconos import kernel as sk
from siconos import numerics as sn

THETA, TOLERANCE = 0.5, 1e-12  # of the method, and of the friction problem's solution


class Pair(sk.NewtonEuler3DR):
    """The relation of one contact."""

    def __init__(self, contact):
        super().__init__()
        self.contact = contact

    def computeh(self, time, q, y):
        poses = [(row[:3].tolist(), row[3:].tolist()) for row in np.reshape(q, (-1, 7))]
        gap, normal, place = contacts.touch(self.contact, [*poses, ([0.0] * 3, [1.0, 0.0, 0.0, 0.0])][:2])
        y[0] = gap
        self.pc1()[:], self.nc()[:] = place, normal  # their setters end the process (SIGSEGV, seen in 4.4.0)
        self.pc2()[:] = np.array(place) - gap * np.array(normal)


def main():
    problem = contacts.read("siconos")
    h, steps = problem["step"], sum(problem["counts"])
    model = sk.NonSmoothDynamicalSystem(0.0, (steps + 1) * h)
    bodies, kept = [], []  # what Python alone refers to would be freed
    for given in problem["bodies"]:
        body = sk.NewtonEulerDS(given["position"] + given["orientation"], given["velocity"] + given["spin"],
                                given["mass"], np.array(given["inertia"]))  # fmt: skip
        kept.append(given["mass"] * np.array(problem["gravity"]))
        body.setFExtPtr(kept[-1])
        model.insertDynamicalSystem(body)
        bodies.append(body)
    for one in problem["contacts"]:
        law, pair = sk.NewtonImpactFrictionNSL(one["rebound"], 0.0, one["friction"], 3), Pair(one)
        kept += [law, pair, sk.Interaction(law, pair)]
        model.link(kept[-1], *(bodies[k] for k in (one["a"], one["b"]) if k >= 0))
    friction = sk.FrictionContact(3, sn.SICONOS_FRICTION_3D_NSGS)
    friction.numericsSolverOptions().dparam[sn.SICONOS_DPARAM_TOL] = TOLERANCE
    friction.numericsSolverOptions().iparam[sn.SICONOS_IPARAM_MAX_ITER] = 1000
    run = sk.TimeStepping(model, sk.TimeDiscretisation(0.0, h), sk.MoreauJeanOSI(THETA), friction)
    for count in problem["counts"]:
        for _ in range(count):
            run.computeOneStep()
            run.nextStep()
        rows = [[*body.q().tolist(), *body.twist().tolist()] for body in bodies]
        contacts.json.dump(rows, sys.stdout)
        print(flush=True)


main()
