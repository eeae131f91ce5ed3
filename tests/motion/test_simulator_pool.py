from pbpf_drake.motion.simulator_pool import SimulatorPool


def _make_pool() -> tuple[SimulatorPool, list]:
    """Returns a pool of strings, and the sets and draws they are made of."""
    made: list[tuple[tuple[int, ...], int]] = []

    def make(link_set: tuple[int, ...], draw: int) -> str:
        made.append((link_set, draw))
        return f"simulator {draw} with {link_set}"

    return SimulatorPool(make), made


def test_a_simulator_is_made_when_it_is_first_used_and_kept():
    pool, made = _make_pool()
    assert made == []
    assert pool.Simulators(()).Get(3) == "simulator 3 with ()"
    assert pool.Simulators((5,)).Get(3) == "simulator 3 with (5,)"
    assert pool.Simulators(()).Get(3) is pool.Simulators(()).Get(3)
    assert made == [((), 3), ((5,), 3)]


def test_what_is_discarded_is_made_anew():
    pool, made = _make_pool()
    simulators = pool.Simulators(())
    simulators.Get(2)
    simulators.Discard(2)
    simulators.Discard(5)
    pool.Simulators(()).Get(2)
    assert made == [((), 2), ((), 2)]


def test_the_links_that_were_not_used_the_longest_are_given_up():
    pool, made = _make_pool()
    for link_set in [(0,), (1,), (2,), (0,), (3,), (4,)]:
        pool.Simulators(link_set).Get(0)
    assert len(made) == 5
    for link_set in (0,), (2,), (3,), (4,):
        pool.Simulators(link_set).Get(0)
    assert len(made) == 5
    pool.Simulators((1,)).Get(0)
    assert len(made) == 6
