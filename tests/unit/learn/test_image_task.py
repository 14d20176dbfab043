"""Batches of the training on images."""

import numpy as np

from needs import needs
from palpate.learn.training_set import TrainingSet


def test_images_are_shifted_by_up_to_a_fortieth_of_their_side_in_all_directions() -> None:
    """Images of 84 px with one bright point: 2 px up, down, left and right, each equally often."""
    torch = needs("torch")
    from palpate.learn.train_member import ImageTask

    images = np.zeros((4, 60, 84), np.uint8)
    images[:, 30, 40] = 255
    train = np.array([True, True, True, False])
    task = ImageTask("n", TrainingSet(images, np.eye(4), train, ~train))
    random, seen = [torch.Generator().manual_seed(0)], []
    for _ in range(200):
        inputs, targets = task.draw(torch.tensor([[2]]), 0.5, random)
        place = np.unravel_index(int(inputs.argmax()), inputs.shape[-2:])
        seen.append((int(place[0]) - 30, int(place[1]) - 40))
        assert np.array_equal(targets[0, 0], task.targets[2])
    counts = np.array([np.bincount(np.array(each) + 2, minlength=5) for each in zip(*seen, strict=True)])
    assert counts.shape == (2, 5)
    assert counts.min() > 20
