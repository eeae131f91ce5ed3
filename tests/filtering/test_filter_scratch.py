import copy

from update_fixtures import make_update

from pbpf_drake.filtering.filter_scratch import FilterScratch


def test_what_the_update_works_in_is_made_once():
    scratch = FilterScratch(make_update(), 0.16)
    assert scratch.ForUpdate() is scratch.ForUpdate()


def test_a_copy_has_work_space_and_times_of_its_own():
    scratch = FilterScratch(make_update(), 0.16)
    scratch.pace.AddUpdate(1.0, 10)
    other = copy.deepcopy(scratch)
    assert other.ForUpdate() is not scratch.ForUpdate()
    assert scratch.pace.MaxParticles() is not None
    assert other.pace.MaxParticles() is None
