"""A command that compiles says so, once: it would look as if it hung."""

from __future__ import annotations

import numba

from reports.console import compiling


def test_the_first_compilation_is_told_and_no_other(capsys):
    with compiling():
        for power in (2, 3):
            numba.njit(lambda x, power=power: x**power)(2.0)
    assert capsys.readouterr().err.count("compiling the solver, once on this machine") == 1


def test_what_is_compiled_already_is_not_told(capsys):
    square = numba.njit(lambda x: x * x)
    square(2.0)
    with compiling():
        square(3.0)
    assert capsys.readouterr().err == ""
