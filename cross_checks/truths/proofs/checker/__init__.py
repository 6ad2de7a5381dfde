"""The checker of proofs: a log has hints only, and what this file computes from them is the theorem.

1. At random points, with 300 digits, the motion that the formulas of the log state must obey d'Alembert's principle and
   all closures as `mechanics` derives them from the scene in absolute coordinates. Analytic functions that agree at
   random points are equal with probability 1.
2. Start values are the scene's numbers; rates that loops decide solve the closures.
3. For every step with polynomial p, y = p + V B x and z = p + W B x + w. Bounds of |x| and |w| are a box that
   V B x' = -(p' - f(p)) - R B x + f_z w + o2, g_z w = -(g(p) + S B x + o2) maps into itself, where R and S are the
   defects of the variational equations and o2 is the second order on the box. All are bounded on the whole step:
   series coefficients in ball arithmetic, their tails by Cauchy's estimate on a complex disc.

4. At an impact, the box moves by the saltation matrix, bounded on all states of the window in which it happens.
   Clearances and states after impacts are compared as in 1: Newton's law, an impulse along the clearance's derivatives.

`mechanics` and `model` do 1 and 2, `impacts` does 4; they change with what proofs cover. `formulas`, `bounds` and
`proof`, 400 lines, do 3 for any formulas.

Floats: GAMMA bounds the rounding of a product of matrices with up to 9000 terms a sum; `up` exceeds a sum of
non-negative terms. The step is the unit of time within itself.
"""
