from dataclasses import replace

import pytest

from corsmal.errors import ArgumentError
from corsmal.filling import FillingTraining
from corsmal.filling.config import PooledConfig
from tests.filling.made import SMALL


def test_paper_has_two_passes_150_epochs_and_rule_1():
    paper = FillingTraining.of("paper")
    assert (paper.tasks, paper.epochs, paper.keep, len(paper.networks)) == (("type", "level"), 150, "best", 1)
    [network] = paper.networks
    assert (network.channels, network.features, network.heads, network.blocks) == (8, 128, 4, 3)
    assert (network.duration_input, network.decoding) == (False, "independent")


def test_tuned_averages_at_most_eight_networks_that_know_the_duration():
    tuned = FillingTraining.of("tuned")
    assert (tuned.tasks, tuned.keep) == (("both",), "last")
    assert len(tuned.networks) <= 8
    assert sum(network.standardise for network in tuned.networks) == len(tuned.networks) / 2
    assert {(network.duration_input, network.decoding) for network in tuned.networks} == {(True, "feasible")}


def test_released_trains_the_authors_network_one_recording_at_a_time():
    released = FillingTraining.of("released")
    assert (released.batch, released.epochs, released.keep, released.tasks) == (1, 100, "best", ("type", "level"))
    assert (released.optimiser, released.momentum, released.rate, released.schedule) == ("sgd", 0.5, 1e-3, "steps")
    [network] = released.networks
    assert (network.channels, network.hidden, network.head_hidden, network.dropout) == (8, 256, 32, 0.05)


def test_settings_are_fitted_to_the_features_form():
    tuned = FillingTraining.tuned()
    fitted = tuned.fitted_to(channels=1, features=64)
    assert {(network.channels, network.features) for network in fitted.networks} == {(1, 64)}
    assert fitted.fitted_to(channels=8, features=128) == tuned


@pytest.mark.parametrize(
    "changes",
    [
        {"networks": ()},
        {"networks": (SMALL,) * 9},
        {"networks": (SMALL, replace(SMALL, decoding="feasible"))},
        {"passes": "both"},
        {"networks": (PooledConfig(),)},
        {"keep": "first"},
        {"schedule": "linear"},
        {"epochs": 0},
        {"batch": 2.0},
        {"rate": 0.0},
        {"weight_decay": -1.0},
        {"momentum": 1.0},
        {"optimiser": "adam"},
    ],
)
def test_settings_that_cannot_be_are_refused(changes):
    with pytest.raises(ArgumentError, match="must"):
        replace(FillingTraining.paper(), **changes)


def test_unknown_preset_is_refused():
    with pytest.raises(ArgumentError, match="preset must be one of"):
        FillingTraining.of("best")
