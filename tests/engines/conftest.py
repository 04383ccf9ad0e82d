import pytest

from corsmal.dataset import open_dataset


@pytest.fixture(scope="module")
def dataset(tiny_dataset_root):
    return open_dataset(tiny_dataset_root)
