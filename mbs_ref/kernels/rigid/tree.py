"""O(N) elimination of the augmented system along the joint tree, in blocks that a core supplies.

Leaf to root, a body with block M, force f and joint rows J a + K a_parent = gamma is condensed into its
parent: with S = J M^-1 J^T,
    M_parent += K^T S^-1 K        f_parent -= K^T S^-1 (J M^-1 f - gamma)
Root to leaf, lambda = S^-1 (J M^-1 f + K a_parent - gamma) and a = M^-1 (f - J^T lambda). This is block
Gaussian elimination of [M Cq^T; Cq 0] (Fox 1999 eq 9) in tree order: no fill outside the blocks. Closures of loops
are eliminated on the way (mbs_ref.kernels.rigid.elimination).

`loops` is None in open trees, and for them no code that stands behind `loops is not None` is compiled.
"""

from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.rigid import elimination
from mbs_ref.kernels.rigid import geometry as core


@jit
def factor_tree(model, work, loops):
    """Factor every body's block and joint, leaf to root, and the closures at their apexes."""
    parent = model.bodies.parent
    n = parent.shape[0]
    core.start_blocks(model, work)
    if loops is not None:
        elimination.begin_closures(model, work)
    for i in range(n - 1, -1, -1):
        if loops is not None and loops.closed[i, 0] < loops.closed[i, 1]:
            elimination.eliminate_closures(model, work, i)
        core.factor_body(model, work, i, parent[i])
        if loops is not None and loops.entry[i] < loops.entry[i + 1]:
            elimination.pass_rows(model, work, i)
    if loops is not None:
        elimination.eliminate_closures(model, work, n)


@jit
def solve_tree(model, work, loops, gamma, acceleration, multiplier):
    """Solve with the forces in the tree's load (overwritten) and the rows' right-hand side `gamma`.

    acceleration (n + 1, rates) and multiplier (n_slots, rates) receive the result; ground's row stays zero.
    """
    parent, load, closures, block = model.bodies.parent, work.tree.load, work.closures, core.block(model)
    n = parent.shape[0]
    if loops is not None:
        elimination.start_rows(block, loops, closures, gamma)
    for i in range(n - 1, -1, -1):
        if loops is not None and loops.closed[i, 0] < loops.closed[i, 1]:
            elimination.condense(block, loops, closures, i, load[i])
        core.solve_free(model, work, i, parent[i], gamma[i], multiplier[i])
        if loops is not None and loops.entry[i] < loops.entry[i + 1]:
            elimination.take_free(block, loops, closures, i, load[i], gamma[i])
    if loops is not None:
        elimination.condense(block, loops, closures, n, load[n])
        elimination.substitute(block, loops, closures, n, acceleration[n], multiplier)
    for i in range(n):
        core.accelerate_body(model, work, i, parent[i], multiplier[i], acceleration)
        if loops is not None and loops.entry[i] < loops.entry[i + 1]:
            elimination.take_closures(block, loops, closures, i, acceleration[i], multiplier[i])
        if loops is not None and loops.closed[i, 0] < loops.closed[i, 1]:
            elimination.substitute(block, loops, closures, i, acceleration[i], multiplier)
