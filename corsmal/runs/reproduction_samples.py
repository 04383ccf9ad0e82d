"""What the filling networks of a reproduction are trained on."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from corsmal.dataset import Dataset
from corsmal.errors import CorsmalError
from corsmal.runs.reproduction_settings import ReproductionSettings
from corsmal.store import Store

if TYPE_CHECKING:
    from corsmal.filling import FillingSample


def training_samples(
    dataset: Dataset,
    settings: ReproductionSettings,
    *,
    store: Store,
    progress: Callable[[float], None],
    note: Callable[[str], None],
) -> "list[FillingSample]":
    """The recordings whose filling is annotated, with the features that the settings name.

    Args:
        dataset: the training set.
        settings: of the reproduction.
        store: keeps log-mel rows.
        progress: called with the fraction that is done, 0..1.
        note: called with a sentence for every recording that is left out, or seen by no network.
    """
    from corsmal.filling import filling_samples  # noqa: PLC0415 - loads PyTorch
    from corsmal.filling.features import training_features  # noqa: PLC0415 - as above
    from corsmal.filling.sight import sight_features  # noqa: PLC0415 - as above

    found, seen, front_end = {}, {}, settings.filling.front_end
    known = dataset.table.index[dataset.table[["filling_type", "filling_level"]].notna().all(axis=1)]
    for done, name in enumerate(known):
        progress(done / len(known))
        try:
            heard = training_features(dataset[name], front_end=front_end, folder=settings.features, store=store)
            found[name] = heard.values
        except CorsmalError as error:
            note(f"{name}: {error}; left out of the filling's training")
            continue
        try:
            if settings.sight is not None:
                seen[name] = sight_features(settings.sight, name)
        except CorsmalError as error:
            note(f"{name}: {error}; only its sound is used")
    return filling_samples(dataset.table, found, sight=seen)
