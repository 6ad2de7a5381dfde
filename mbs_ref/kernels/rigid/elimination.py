"""Loop closures, eliminated at the apex of their loops inside the tree recursion: linear where loops are local.

A closure has rows G a = gamma and multipliers mu. Leaf to root, a body with block M, joint rows J a + K a_parent, and
S = J M^-1 J^T is condensed into its parent; the rows P of the closures that pass it are then

    P_parent -= P M^-1 J^T S^-1 K    D += P B P^T    gamma -= P a_0,    B = M^-1 - M^-1 J^T S^-1 J M^-1

with a_0 what the body's own forces do while its parent rests: P_parent a_parent - D mu = gamma holds for the path
below. At the apex, where both sides have arrived, all of the closure's rows are there and mu is eliminated before the
apex is condensed: M += P^T D^-1 P, f += P^T D^-1 gamma, and likewise D and P of the closures that meet it. This is
block Gaussian elimination of [M C_q^T; C_q 0], fill in the blocks of closures alone that share a body of their paths,
or get to by fill.

The rank may be decided there, with the apex at rest. Joints depend on relative poses, so that moving the apex with all
that hangs on it, V, keeps their rows: A V + A_apex = 0 for the rows A of the part below. What is dependent in A is so
in [A, A_apex] too, whatever the apex does. D is positive semidefinite, whence a pivot that vanishes is a row that
depends on those before, in any order. Dependent rows get mu = 0: accelerations do not depend on their choice.
Within a closure the largest pivot goes first; of its rows no more are taken than are independent in a pose that is not
singular (`Loops.most`): off the constraints, where an integrator's stages are, the redundant rows of an
overconstrained loop such as Bricard's look independent by the square of the distance.

`block` is a tuple as long as a body has rates, 3 or 6, and as a closure can have rows: so loops over it have bounds
that the compiler knows. Rows that a closure does not have are zero.
"""

from mbs_ref.kernels.algebra.lanes import either, exceeds, smaller, vanishes
from mbs_ref.kernels.jit import bare, jit, placed
from mbs_ref.kernels.rigid.geometry import block, pass_closure, plus_mobility

RANK_TOLERANCE = 1e-13  # of a pivot against the row's mobility without joints


@placed
def rows_times(block, body, jacobian, acceleration, out):
    """Write every constraint row applied to accelerations (n + 1, rates) into out (n_slots, rows a slot)."""
    for slot in range(out.shape[0]):
        for row in range(len(block)):
            total = 0.0
            for side in range(2):
                of = body[slot, side]
                for c in range(len(block)):
                    total += jacobian[slot, side, row, c] * acceleration[of, c]
            out[slot, row] = total


# --- factor -----------------------------------------------------------------------------------------


@jit
def begin_closures(model, work):
    """Put the closures' rows where their paths begin."""
    loops, closures = model.loops, work.closures
    for k in range(loops.slot.shape[0]):
        for r in range(loops.count[k]):
            closures.scale[k, r] = _row_mobility(model, work, loops.slot[k], r)
    start_closures(block(model), loops, closures, work.rows.jacobian)


@jit
def _row_mobility(model, work, slot, row):
    """Return a scale of G M^-1 G^T of one row, the bodies taken as free."""
    total = 0.0
    for side in range(2):
        body = model.slots.body[slot, side]
        if body < model.bodies.mass.shape[0]:
            total = plus_mobility(model, work, total, body, work.rows.jacobian[slot, side, row])
    return total


@placed
def start_closures(block, loops, closures, jacobian):
    """Put the rows of closures where their paths begin; `closures.scale` is given."""
    closures.regularity[0] = 1.0
    list_live(loops, closures)
    for k in range(loops.slot.shape[0]):
        if closures.empty[k] == 1:
            closures.rank[k] = loops.count[k]  # its multiplier is known: zero
            continue
        for place in range(loops.place[k], loops.place[k + 1]):
            _clear(block, closures.passed[place])
        for side in range(2):
            start = loops.start[k, side]
            if start >= 0:
                for c in range(len(block)):
                    for r in range(len(block)):
                        closures.passed[start, c, r] = jacobian[loops.slot[k], side, r, c]
        _clear(block, closures.own[k])
        start_own(loops, closures, k)
        for j in range(closures.first[k], closures.first[k + 1]):
            _clear(block, closures.coupling[closures.met[j]])


@placed
def _list_in_floats(loops, closures):
    """Find the closures whose rows are empty, and leave these out of the lists; most often nothing has changed."""
    changed = False
    for k in range(loops.slot.shape[0]):
        mobility = 0.0
        for r in range(loops.count[k]):
            mobility += closures.scale[k, r]
        empty = 1 if vanishes(mobility) else 0
        if empty != closures.empty[k]:
            closures.empty[k] = empty
            changed = True
    if changed:
        _keep_live(closures.empty, loops.entry, loops.passing, closures.entry, closures.passing)
        _keep_live(closures.empty, loops.first, loops.met, closures.first, closures.met)


@placed
def _start_in_lanes(loops, closures, k):
    for r in range(loops.count[k]):
        is_empty = 1.0 - exceeds(closures.scale[k, r], 0.0)
        closures.own[k, r, r] = is_empty
        closures.scale[k, r] = closures.scale[k, r] + is_empty


# In lanes a row that is empty stays, and what multiplies its multiplier is 1: the multiplier vanishes.
list_live = either("list_live(loops, closures)", _list_in_floats, bare(lambda loops, closures: None))
start_own = either("start_own(loops, closures, k)", bare(lambda loops, closures, k: None), _start_in_lanes)


@placed
def _keep_live(empty, start, closure, first, place):
    """List, for each range of `start`, the places in it whose `closure` is not empty: ranges `first` of `place`."""
    count = 0
    for i in range(start.shape[0] - 1):
        first[i] = count
        for e in range(start[i], start[i + 1]):
            if empty[closure[e]] == 0:
                place[count] = e
                count += 1
    first[start.shape[0] - 1] = count


@placed
def _clear(block, target):
    for r in range(len(block)):
        for c in range(len(block)):
            target[r, c] = 0.0


@jit
def pass_rows(model, work, i):
    """Condense body i under the closures that pass it: their rows go on to its parent."""
    loops, closures = model.loops, work.closures
    for j in range(closures.entry[i], closures.entry[i + 1]):
        e = closures.passing[j]
        pass_closure(model, work, i, loops.here[e], loops.next[e], loops.count[loops.passing[e]])
    couple(block(model), loops, closures, i)


@placed
def couple(block, loops, closures, body):
    """D += P B P^T for the closures that pass a body, once `column` holds B P^T."""
    end = closures.entry[body + 1]
    for i in range(closures.entry[body], end):
        e = closures.passing[i]
        k = loops.passing[e]
        rows, single = closures.passed[loops.here[e]], loops.count[k] == 1
        _add_product(block, single, rows, closures.column[loops.here[e]], closures.own[k])
        at = closures.first[k]
        for j in range(i + 1, end):
            f = closures.passing[j]
            other = loops.passing[f]
            at = _meeting(loops, closures, at, other)
            both = single and loops.count[other] == 1
            _add_product(block, both, rows, closures.column[loops.here[f]], closures.coupling[closures.met[at]])


@placed
def _add_product(block, single, a, b, target):
    """target += a^T b; of `single` rows, as contacts have, no more than the one number."""
    if single:
        total = 0.0
        for c in range(len(block)):
            total += a[c, 0] * b[c, 0]
        target[0, 0] += total
        return
    for r in range(len(block)):
        for s in range(len(block)):
            total = 0.0
            for c in range(len(block)):
                total += a[c, r] * b[c, s]
            target[r, s] += total


@placed
def _meeting(loops, closures, at, other):
    """Return where in `closures.met`, from `at` on, a closure meets another one."""
    while loops.met[closures.met[at]] != other:
        at += 1
    return at


@bare
def _largest_pivot(a, order, scale, rank, count):
    best, largest = rank, 0.0
    for i in range(rank, count):
        relative = a[order[i], order[i]] / scale[order[i]]
        if relative > largest:
            best, largest = i, relative
    return best, largest, not largest > RANK_TOLERANCE


@bare
def _in_own_order(a, order, count):
    for i in range(count):
        order[i] = i


# Lanes take the rows in the order of pivots that a system alone finds at its start, and which the scratch then holds.
_start_order = either("_start_order(a, order, count)", _in_own_order, bare(lambda a, order, count: None))
# Return the place of the next pivot, its relative size, and whether no row is left that is independent of those before.
_pivot = either(
    "_pivot(a, order, scale, rank, count)", _largest_pivot,
    bare(lambda a, order, scale, rank, count: (rank, a[order[rank], order[rank]] / scale[order[rank]], False)),
)  # fmt: skip


@placed
def _factor_own(loops, closures, k):
    """Factor a closure's own D = L E L^T in the order of its pivots; `inverse` receives 1 / E.

    Rows keep their places: L_ij lies where D has the rows `order` i and j.
    """
    a, order, scale, count = closures.own[k], closures.order[k], closures.scale[k], loops.count[k]
    _start_order(a, order, count)
    rank = 0
    while rank < loops.most[k]:
        best, largest, is_none = _pivot(a, order, scale, rank, count)
        if is_none:
            break
        closures.regularity[0] = smaller(closures.regularity[0], largest)
        order[rank], order[best] = order[best], order[rank]
        p = order[rank]
        inverse = 1.0 / a[p, p]
        for i in range(rank + 1, count):
            q = order[i]
            low = a[q, p] * inverse
            for j in range(rank + 1, i + 1):
                o = order[j]
                a[q, o] -= low * a[p, o]
                a[o, q] = a[q, o]
            a[q, p] = low
        closures.inverse[k, rank] = inverse
        rank += 1
    closures.rank[k] = rank


@placed
def _forward(block, closures, k, rows):
    """Replace a block of a closure's rows by L^-1 times it, in place."""
    own, order = closures.own[k], closures.order[k]
    for i in range(1, closures.rank[k]):
        for j in range(i):
            low = own[order[i], order[j]]
            for c in range(len(block)):
                rows[order[i], c] -= low * rows[order[j], c]


@placed
def _take_product(block, closures, k, count, a, b, target):
    """target -= a^T E^-1 b, the rows of a and b being a closure's."""
    for r in range(count):
        for c in range(len(block)):
            total = 0.0
            for j in range(closures.rank[k]):
                p = closures.order[k, j]
                total += a[p, r] * closures.inverse[k, j] * b[p, c]
            target[r, c] -= total


@placed
def _update_met(block, loops, closures, k):
    """D -= Z^T E^-1 Z among the closures that meet this one, Z = L^-1 D."""
    end = closures.first[k + 1]
    for i in range(closures.first[k], end):
        _forward(block, closures, k, closures.coupling[closures.met[i]])
    for i in range(closures.first[k], end):
        m = closures.met[i]
        one = loops.met[m]
        count, z = loops.count[one], closures.coupling[m]
        _take_product(block, closures, k, count, z, z, closures.own[one])
        at = closures.first[one]
        for j in range(i + 1, end):
            n = closures.met[j]
            at = _meeting(loops, closures, at, loops.met[n])
            _take_product(block, closures, k, count, z, closures.coupling[n], closures.coupling[closures.met[at]])


@placed
def _update_apex(block, loops, closures, k, articulated):
    """M += Z^T E^-1 Z of the apex, Z = L^-1 P, and P -= (L^-1 D)^T E^-1 Z of the closures that meet this one."""
    own, order, z = closures.own[k], closures.order[k], closures.passed[loops.summit[k]]
    for i in range(1, closures.rank[k]):
        for j in range(i):
            low = own[order[i], order[j]]
            for c in range(len(block)):
                z[c, order[i]] -= low * z[c, order[j]]
    for j in range(closures.rank[k]):
        p, inverse = order[j], closures.inverse[k, j]
        for r in range(len(block)):
            weight = z[r, p] * inverse
            for c in range(r + 1):
                articulated[r, c] += weight * z[c, p]
        for i in range(closures.first[k], closures.first[k + 1]):
            m = closures.met[i]
            passed = closures.passed[loops.above[m]]
            for c in range(len(block)):
                weight = z[c, p] * inverse
                for r in range(len(block)):
                    passed[c, r] -= weight * closures.coupling[m, p, r]


@placed
def eliminate(block, loops, closures, body, articulated):
    """Eliminate the closures whose apex is a body before the body itself, and those of ground at the end.

    articulated (rates, rates) is the body's block, of which the lower triangle is stored.
    """
    for k in range(loops.closed[body, 0], loops.closed[body, 1]):
        if closures.empty[k] == 0:
            _factor_own(loops, closures, k)
            _update_met(block, loops, closures, k)
            if loops.summit[k] >= 0:
                _update_apex(block, loops, closures, k, articulated)


@jit
def eliminate_closures(model, work, i):
    """Eliminate the closures whose apex is body i, or ground."""
    eliminate(block(model), model.loops, work.closures, i, work.tree.articulated[i])


# --- solve ------------------------------------------------------------------------------------------


@placed
def start_rows(block, loops, closures, gamma):
    """Put the closures' right-hand sides where they are condensed."""
    for k in range(loops.slot.shape[0]):
        for r in range(len(block)):
            closures.rhs[k, r] = gamma[loops.slot[k], r]


@placed
def take_free(block, loops, closures, body, load, gamma):
    """gamma -= P a_0 for the closures that pass a body with forces f (rates,) and right-hand sides of its joint.

    a_0 = B f + M^-1 J^T S^-1 gamma, and B P^T and S^-1 J M^-1 P^T are in `column` and `joint`.
    """
    for i in range(closures.entry[body], closures.entry[body + 1]):
        e = closures.passing[i]
        k, here = loops.passing[e], loops.here[e]
        for r in range(len(block)):
            total = 0.0
            for c in range(len(block)):
                total += closures.column[here, c, r] * load[c] + closures.joint[here, c, r] * gamma[c]
            closures.rhs[k, r] -= total


@placed
def _condense_one(block, loops, closures, k, load):
    rhs, own, order, rank = closures.rhs[k], closures.own[k], closures.order[k], closures.rank[k]
    for i in range(rank):
        p = order[i]
        total = 0.0
        for j in range(i):
            total += own[p, order[j]] * rhs[order[j]]
        rhs[p] -= total
        weight = closures.inverse[k, i] * rhs[p]
        for j in range(closures.first[k], closures.first[k + 1]):
            m = closures.met[j]
            one = loops.met[m]
            for r in range(len(block)):
                closures.rhs[one, r] -= closures.coupling[m, p, r] * weight
        if loops.summit[k] >= 0:
            for c in range(len(block)):
                load[c] += closures.passed[loops.summit[k], c, p] * weight


@placed
def condense(block, loops, closures, body, load):
    """Condense the right-hand sides of the closures whose apex is a body: f += P^T D^-1 gamma."""
    for k in range(loops.closed[body, 0], loops.closed[body, 1]):
        if closures.empty[k] == 0:
            _condense_one(block, loops, closures, k, load)


@placed
def _substitute_one(block, loops, closures, k, acceleration):
    """mu = D^-1 (P a - D mu - gamma), the middle term that of the closures that this one meets."""
    own, order, mu, rank = closures.own[k], closures.order[k], closures.mu[k], closures.rank[k]
    for i in range(rank - 1, -1, -1):
        p = order[i]
        total = -closures.rhs[k, p]
        if loops.summit[k] >= 0:
            for c in range(len(block)):
                total += closures.passed[loops.summit[k], c, p] * acceleration[c]
        for j in range(closures.first[k], closures.first[k + 1]):
            m = closures.met[j]
            for r in range(len(block)):
                total -= closures.coupling[m, p, r] * closures.mu[loops.met[m], r]
        later = 0.0
        for j in range(i + 1, rank):
            later += own[order[j], p] * mu[order[j]]
        mu[p] = total * closures.inverse[k, i] - later


@placed
def substitute(block, loops, closures, body, acceleration, multiplier):
    """Find the multipliers of the closures whose apex is a body; acceleration (rates,) is the apex's."""
    for k in range(loops.closed[body, 1] - 1, loops.closed[body, 0] - 1, -1):
        for r in range(len(block)):
            closures.mu[k, r] = 0.0
        if closures.empty[k] == 0:
            _substitute_one(block, loops, closures, k, acceleration)
        for r in range(len(block)):
            multiplier[loops.slot[k], r] = closures.mu[k, r]


@placed
def take_closures(block, loops, closures, body, acceleration, multiplier):
    """a -= B P^T mu, and the joint's multipliers likewise, of the closures that pass a body."""
    for i in range(closures.entry[body], closures.entry[body + 1]):
        e = closures.passing[i]
        k, here = loops.passing[e], loops.here[e]
        for c in range(len(block)):
            change, joint = 0.0, 0.0
            for r in range(len(block)):
                change += closures.column[here, c, r] * closures.mu[k, r]
                joint += closures.joint[here, c, r] * closures.mu[k, r]
            acceleration[c] -= change
            multiplier[c] -= joint
