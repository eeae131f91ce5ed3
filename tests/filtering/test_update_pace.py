import pytest

from pbpf_drake.filtering.update_pace import UpdatePace

PERIOD = 0.1
BUDGET = 0.08


def test_nothing_is_known_before_the_first_update():
    assert UpdatePace(PERIOD).MaxParticles() is None


@pytest.mark.parametrize("start", [1, 20, 1000])
@pytest.mark.parametrize("fixed, each", [(0.0, 1e-3), (0.02, 5e-4)])
def test_the_number_that_fits_is_approached(start, fixed, each):
    dut, count = UpdatePace(PERIOD), start
    for _ in range(30):
        dut.AddUpdate(fixed + each * count, count)
        count = dut.MaxParticles()
    assert fixed + each * count == pytest.approx(BUDGET, rel=0.02)


def test_one_update_that_took_long_does_not_count():
    dut = UpdatePace(PERIOD)
    for seconds in (0.04, 0.04, 2.0):
        dut.AddUpdate(seconds, 40)
    assert dut.MaxParticles() == 80


def test_two_that_took_long_do_and_so_does_the_only_one():
    dut = UpdatePace(PERIOD)
    dut.AddUpdate(0.16, 40)
    assert dut.MaxParticles() == 20
    for seconds in (0.04, 0.16, 0.16):
        dut.AddUpdate(seconds, 40)
    assert dut.MaxParticles() == 20


def test_where_nothing_fits_one_particle_is_left():
    dut = UpdatePace(PERIOD)
    dut.AddUpdate(3.0, 5)
    assert dut.MaxParticles() == 1
