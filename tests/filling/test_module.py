from dataclasses import replace

import numpy as np
import pytest
import torch

from corsmal.filling.module import FillingModule
from corsmal.filling.samples import Batches
from tests.filling.made import JOINT, PAPER, made_features, made_samples, same, state


def passes(training):
    """Every parameter before and after each pass of one epoch."""
    torch.manual_seed(0)
    module = FillingModule(training, 0, made_samples(21), [], seed=0)
    optimiser = module.configure_optimizers()
    module.log = lambda *_, **__: None
    for task in training.tasks:
        before = state(module.network)
        for batch in Batches(made_samples(21), size=8, tasks=(task,), rng=np.random.default_rng(0)):
            optimiser.zero_grad()
            module.training_step(batch).backward()
            optimiser.step()
        after = state(module.network)
        learned = {name for name, _ in module.network.named_parameters()}
        yield task, {name for name in learned if not torch.equal(before[name], after[name])}, learned


def test_each_pass_changes_the_encoders_and_its_own_head_alone():
    for _ in range(2):  # the second epoch too, when the optimiser remembers gradients of both heads
        for task, changed, learned in passes(PAPER):
            other = "level_head" if task == "type" else "type_head"
            assert changed == {name for name in learned if not name.startswith(other)}


def test_frozen_head_stays_though_the_optimiser_remembers_it():
    torch.manual_seed(0)
    module = FillingModule(PAPER, 0, made_samples(21), [], seed=0)
    module.log = lambda *_, **__: None
    optimiser = module.configure_optimizers()
    for task, head in (("level", None), ("type", module.network.level_head), ("level", module.network.type_head)):
        before = None if head is None else state(head)
        for batch in Batches(made_samples(21), size=8, tasks=(task,), rng=np.random.default_rng(0)):
            optimiser.zero_grad()
            module.training_step(batch).backward()
            optimiser.step()
        assert head is None or same(before, state(head))


def test_joint_pass_changes_everything():
    [(task, changed, learned)] = passes(JOINT)
    assert (task, changed) == ("both", learned)


def test_rate_is_lowered_by_half_a_cosine():
    module = FillingModule(replace(JOINT, schedule="cosine", epochs=4), 0, made_samples(21), [], seed=0)
    made = module.configure_optimizers()
    rates = []
    for _ in range(4):
        rates.append(made["optimizer"].param_groups[0]["lr"] / JOINT.rate)
        made["optimizer"].step()
        made["lr_scheduler"].step()
    assert rates == pytest.approx([1, 0.5 + 0.125**0.5, 0.5, 0.5 - 0.125**0.5])


def test_gradient_descent_steps_by_hand():
    settings = replace(JOINT, optimiser="sgd", momentum=0.5, rate=0.1, weight_decay=0.0)
    module = FillingModule(settings, 0, made_samples(21), [], seed=0)
    optimiser, weights = module.configure_optimizers(), module.network.cls
    before = weights.detach().clone()
    for _ in range(2):
        optimiser.zero_grad()
        weights.sum().backward()  # a gradient of 1: the first step is 0.1, the second 0.1 (1 + 0.5)
        optimiser.step()
    torch.testing.assert_close(weights.detach(), before - 0.25)


def test_rate_is_lowered_to_a_tenth_after_half_and_after_three_quarters():
    module = FillingModule(replace(JOINT, schedule="steps", epochs=8), 0, made_samples(21), [], seed=0)
    made = module.configure_optimizers()
    rates = []
    for _ in range(8):
        rates.append(made["optimizer"].param_groups[0]["lr"] / JOINT.rate)
        made["optimizer"].step()
        made["lr_scheduler"].step()
    assert rates == pytest.approx([1, 1, 1, 1, 0.1, 0.1, 0.01, 0.01])


def test_alternating_epoch_is_the_type_pass_and_then_the_level_pass():
    module = FillingModule(PAPER, 0, made_samples(21), made_samples(7), seed=0)
    assert [batch.task for batch in module.train_dataloader()] == ["type"] * 3 + ["level"] * 3
    [validation] = module.val_dataloader()
    assert (validation.task, len(validation.types)) == ("both", 7)


def test_losses_are_mean_cross_entropies_of_recordings_of_any_length():
    samples = made_samples(6)
    samples.append(replace(samples[0], features=made_features(60)))
    module = FillingModule(JOINT, 0, made_samples(21), [], seed=0).eval()
    logged = {}
    module.log = lambda name, value, **_: logged.update({name: value.item()})
    [batch] = Batches(samples, size=7, tasks=("both",), rng=None)
    loss = module.training_step(batch)
    kind = level = 0.0
    for sample in samples:
        types, levels = module.network(torch.from_numpy(sample.features)[None])
        kind -= types[0].softmax(dim=0)[sample.filling_type].log().item() / 7
        level -= levels[0].softmax(dim=0)[sample.filling_level].log().item() / 7
    assert loss.item() == pytest.approx(kind + level, abs=1e-5)
    assert logged == pytest.approx({"type_loss": kind, "level_loss": level}, abs=1e-5)
