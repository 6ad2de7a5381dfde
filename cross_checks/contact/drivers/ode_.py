"""Open Dynamics Engine: contacts with ERP = h k/(h k + c) and CFM = 1/(h k + c) (manual, section 3.8)."""

import sys

import contacts
import ode

GROUND = ([0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0])


def main():
    problem = contacts.read("Py3ODE")
    h, world, group = problem["step"], ode.World(), ode.JointGroup()
    world.setGravity(problem["gravity"])
    bodies = []
    for given in problem["bodies"]:
        body, mass, (a, b, c) = ode.Body(world), ode.Mass(), given["inertia"]
        mass.setParameters(given["mass"], 0, 0, 0, a[0], b[1], c[2], a[1], a[2], b[2])
        body.setMass(mass)
        body.setPosition(given["position"])
        body.setQuaternion(given["orientation"])
        body.setLinearVel(given["velocity"])
        body.setAngularVel(given["spin"])
        bodies.append(body)
    poses = lambda k: GROUND if k < 0 else (bodies[k].getPosition(), bodies[k].getQuaternion())  # noqa: E731
    for count in problem["counts"]:
        for _ in range(count):
            for one in problem["contacts"]:
                gap, normal, place = contacts.touch(one, (poses(one["a"]), poses(one["b"])))
                if gap < 0.0:
                    contact, soft = ode.Contact(), h * one["stiffness"] + one["damping"]
                    contact.setContactGeomParams(place, normal, -gap)
                    contact.setMode(ode.ContactSoftERP | ode.ContactSoftCFM | ode.ContactApprox1)
                    contact.setMu(one["friction"])
                    contact.setSoftERP(h * one["stiffness"] / soft)
                    contact.setSoftCFM(1.0 / soft)
                    ends = [None if k < 0 else bodies[k] for k in (one["a"], one["b"])]
                    ode.ContactJoint(world, group, contact).attach(*ends)
            world.step(h)
            group.empty()
        rows = [(*b.getPosition(), *b.getQuaternion(), *b.getLinearVel(), *b.getAngularVel()) for b in bodies]
        contacts.json.dump(rows, sys.stdout)
        print(flush=True)


main()
