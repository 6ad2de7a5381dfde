"""A caller's patience: a run on a busy machine gets the time that it gets on an idle one."""

from __future__ import annotations

import os
import time

import pytest

from cross_checks.isolation.messages import COMPILED, COMPILING, Moment, Patience, moment

START = Moment(wall=0.0, computed=7.0)


def test_waiting_for_a_processor_costs_nothing():
    patience = Patience(10.0, START)
    assert patience.spend(Moment(wall=1e6, computed=16.9)) == ""
    assert "10 s" in patience.spend(Moment(wall=1e6, computed=17.1))


def test_one_who_sleeps_is_given_up_by_the_clock_on_the_wall():
    patience = Patience(10.0, START)
    assert patience.spend(Moment(5.0, 7.0, asleep=True)) == ""  # it may have run until now
    assert patience.spend(Moment(14.0, 7.0, asleep=True)) == ""
    assert "10 s" in patience.spend(Moment(16.0, 7.0, asleep=True))


def test_where_nothing_is_told_the_clock_on_the_wall_counts():
    patience = Patience(10.0, Moment(0.0, None))
    assert patience.spend(Moment(9.0, None)) == ""
    assert "10 s" in patience.spend(Moment(11.0, None))


def test_compiling_is_paid_from_another_purse():
    patience = Patience(10.0, START, compilation=100.0)
    assert patience.spend(Moment(1.0, 8.0), COMPILING) == ""
    assert patience.spend(Moment(2.0, 107.9), COMPILED) == ""
    assert patience.spend(Moment(3.0, 116.8)) == ""
    assert "10 s" in patience.spend(Moment(4.0, 117.0))
    assert "compiled for more than 5 s" in _after_compiling(Patience(10.0, START, compilation=5.0))


def _after_compiling(patience: Patience) -> str:
    patience.spend(START, COMPILING)
    return patience.spend(Moment(1.0, 13.0))


def test_the_system_tells_what_a_process_computes():
    before = moment(os.getpid())
    if before.computed is None:
        pytest.skip("the system does not tell")
    end = time.process_time() + 0.1
    while time.process_time() < end:
        pass
    now = moment(os.getpid())
    assert now.computed is not None
    assert now.computed - before.computed == pytest.approx(0.1, abs=0.03)
    assert not now.asleep


def test_of_a_process_that_is_gone_nothing_is_told():
    assert moment(2**30).computed is None
