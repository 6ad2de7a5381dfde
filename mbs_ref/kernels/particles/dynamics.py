"""The right-hand side of a scene of particles; it is free of constraints."""

from mbs_ref.kernels.algebra.lanes import in_lanes
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.particles.figures import add_figures, add_tides, add_zonals
from mbs_ref.kernels.particles.model import LANES
from mbs_ref.kernels.particles.pair import central_relativity, einstein_infeld_hoffmann, newton_pairs
from mbs_ref.kernels.particles.satellites import add_drags, add_lights, add_points, add_third_bodies

EIH = 2


@jit
def accelerate(model, work):
    """Fill `acceleration` from time, base, delta and velocity in `work`; a field not in use costs a comparison."""
    particles, lanes, relativity = model.particles, work.lanes, model.relativity
    delta, out = in_lanes(lanes.delta), in_lanes(lanes.acceleration)
    for i in range(out.shape[0]):
        for c in range(3):
            out[i, c] = particles.gravity[c]
    newton_pairs(particles.gm, lanes.base, delta, out)
    if relativity.form[0] != 0:
        _relativity(particles.gm, relativity.form[0], relativity.inverse_c2[0], lanes, delta, out)
    if model.zonals.body.shape[0] > 0:
        add_zonals(model, work)
    if model.figures.body.shape[0] > 0:
        add_figures(model, work)
    if model.tides.body.shape[0] > 0:
        add_tides(model, work)
    if model.points.gm.shape[0] > 0:
        add_points(model, work)
    if model.third_bodies.body.shape[0] > 0:
        add_third_bodies(model, work)
    if model.drags.body.shape[0] > 0:
        add_drags(model, work)
    if model.lights.body.shape[0] > 0:
        add_lights(model, work)


@jit
def _relativity(gm, form, inverse_c2, lanes, delta, out):
    velocity, newton = in_lanes(lanes.velocity), in_lanes(lanes.newton)
    if form != EIH:
        central_relativity(gm, inverse_c2, lanes.base, delta, velocity, out)
        return
    for i in range(out.shape[0]):
        for c in range(3):
            newton[i, c] = out[i, c]
    einstein_infeld_hoffmann(
        gm, inverse_c2, lanes.base, delta, velocity, newton, in_lanes(lanes.potential), in_lanes(lanes.speed), out
    )


@jit
def particle_derivative(model, work, t, y, dy):
    """Write dy/dt = [v, a]: one instant, in every lane."""
    lanes = work.lanes
    n = lanes.base.shape[0]
    for k in range(LANES):
        lanes.time[k] = t
    for i in range(n):
        for c in range(3):
            lanes.base[i, c] = y[3 * i + c]
            dy[3 * i + c] = y[3 * (n + i) + c]
            for k in range(LANES):
                lanes.delta[i, c, k] = 0.0
                lanes.velocity[i, c, k] = y[3 * (n + i) + c]
    accelerate(model, work)
    for i in range(n):
        for c in range(3):
            dy[3 * (n + i) + c] = lanes.acceleration[i, c, 0]
