from palpate.core import child_seed, generator


def test_streams_are_fixed_numbers() -> None:
    assert child_seed(0, "poses") == child_seed(0, "poses")
    assert child_seed(7, "dataset", 20.0, 2.0) == 3360106081


def test_labels_and_seed_separate_streams() -> None:
    seeds = [child_seed(0), child_seed(1), child_seed(0, "a"), child_seed(0, "a", "b"), child_seed(0, 1.0)]
    assert len(set(seeds)) == len(seeds)


def test_generator_repeats_itself() -> None:
    assert generator(3, "jitter").uniform() == generator(3, "jitter").uniform()
