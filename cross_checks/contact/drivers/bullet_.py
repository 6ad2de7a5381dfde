"""Bullet (pybullet): contactStiffness and contactDamping of each body add up like springs in series and dampers."""

import contacts
import pybullet as bullet


def main():
    problem = contacts.read("pybullet")
    world = bullet.connect(bullet.DIRECT)
    bullet.setGravity(*problem["gravity"], physicsClientId=world)
    bullet.setTimeStep(problem["step"])
    options = {"numSolverIterations": 1000, "solverResidualThreshold": 0.0, "contactBreakingThreshold": 1e-4}
    options |= {"enableConeFriction": 1, "restitutionVelocityThreshold": 0.0}
    bullet.setPhysicsEngineParameter(**options, contactSlop=0.0)  # of 10 um, which bodies at rest would sink deeper
    shapes = [[] for _ in problem["bodies"]]
    for one in problem["contacts"]:
        shapes[one["a"]].append((one["radius"], one["center"]))
        if "other" in one and one["b"] >= 0:
            shapes[one["b"]].append((one["other"], one["origin"]))
    bodies = [_body(given, shapes[k]) for k, given in enumerate(problem["bodies"])]
    fixed = {}  # by body, one for each surface that it touches: several in one place would each press its spheres
    for one in problem["contacts"]:
        place = str([one.get(name) for name in ("a", "origin", "axes", "other")])
        if one["b"] < 0 and place not in fixed:
            fixed[place] = _fixed(one)
        other = bodies[one["b"]] if one["b"] >= 0 else fixed[place]
        for body in (bodies[one["a"]], other):
            soft = {"contactStiffness": 2.0 * one["stiffness"], "contactDamping": 0.5 * one["damping"]}
            bullet.changeDynamics(body, -1, lateralFriction=one["friction"] ** 0.5, restitution=0.0, **soft)
        bullet.setCollisionFilterPair(bodies[one["a"]], other, -1, -1, 1)
    for count in problem["counts"]:
        for _ in range(count):
            bullet.stepSimulation()
        rows = []
        for body in bodies:
            place, (x, y, z, w) = bullet.getBasePositionAndOrientation(body)
            rows.append([*place, w, x, y, z, *(c for rate in bullet.getBaseVelocity(body) for c in rate)])
        contacts.json.dump(rows, contacts.sys.stdout)
        print(flush=True)


def _body(given, spheres):
    kinds = {"shapeTypes": [bullet.GEOM_SPHERE] * len(spheres), "radii": [radius for radius, _ in spheres]}
    shape = bullet.createCollisionShapeArray(**kinds, collisionFramePositions=[list(place) for _, place in spheres])
    w, x, y, z = given["orientation"]
    body = bullet.createMultiBody(given["mass"], shape, basePosition=given["position"],
                                  baseOrientation=(x, y, z, w), useMaximalCoordinates=0)  # fmt: skip
    inertia = [given["inertia"][k][k] for k in range(3)]
    bullet.changeDynamics(body, -1, localInertiaDiagonal=inertia, linearDamping=0.0, angularDamping=0.0)
    bullet.resetBaseVelocity(body, given["velocity"], given["spin"])
    bullet.setCollisionFilterGroupMask(body, -1, 0, 0)
    return body


def _fixed(one):
    if "axes" in one:
        shape = bullet.createCollisionShape(bullet.GEOM_PLANE, planeNormal=one["axes"][2])
    else:
        shape = bullet.createCollisionShape(bullet.GEOM_SPHERE, radius=one["other"])
    body = bullet.createMultiBody(0.0, shape, basePosition=one["origin"], useMaximalCoordinates=0)
    bullet.setCollisionFilterGroupMask(body, -1, 0, 0)
    return body


main()
