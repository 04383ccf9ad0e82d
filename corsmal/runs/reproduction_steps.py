"""The steps of a reproduction; what each computes is kept under a digest of what it depends on."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, fields, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from corsmal.dataset import Dataset, TrainedOn
from corsmal.engines.engine import Engine
from corsmal.errors import ArgumentError
from corsmal.estimation import TrainingMeans
from corsmal.runs.making import make_run
from corsmal.runs.reproduction_mass import KEY_DIGITS, final_mass_network, identity_of, mass_predictions
from corsmal.runs.reproduction_notes import filling_notes, mass_notes
from corsmal.runs.reproduction_results import STOPPED, CancelledError, Results, TestResult
from corsmal.runs.reproduction_rows import reproduction_rows
from corsmal.runs.reproduction_samples import training_samples
from corsmal.runs.reproduction_settings import ReproductionSettings, is_filmed, named_tests
from corsmal.stages.mass_rows import mass_rows
from corsmal.stages.settings import EstimateSettings
from corsmal.stages.training_facts import training_record
from corsmal.stages.version import METHOD_VERSION
from corsmal.store import Store, digest
from corsmal.weights import find_weights

if TYPE_CHECKING:
    from corsmal.filling import FillingSample
    from corsmal.mass import MassRow


class Work:
    """The steps in their order.

    Args:
        dataset: the training set.
        settings: the settings.
        store: keeps detections, estimates and features.
        engine: does the recordings' work.
        out: folder for what is kept.
        report: called with a step's name and its share, 0..1.
        cancelled: true ends the work.
    """

    def __init__(
        self,
        dataset: Dataset,
        settings: ReproductionSettings,
        *,
        store: Store,
        engine: Engine,
        out: Path,
        report: Callable[[str, float], None],
        cancelled: Callable[[], bool],
    ) -> None:
        self._dataset, self._settings, self._store, self._engine = dataset, settings, store, engine
        self._out, self._report, self._cancelled = out, report, cancelled
        self._notes: list[str] = []
        self._features: dict[str, str] = {}
        self._heard = ""

    def results(self, tests: Sequence[Dataset]) -> Results:
        """Do what is not done yet."""
        geometry = self._geometry(self._dataset, self._estimate_settings())
        samples = self._samples()
        filling, rounds = self._filling(samples)
        weighed = self._mass_rows(geometry)
        mass = self._mass(weighed)
        filling_path, mass_path = self._final_networks(samples, weighed)
        found = [self._test(name, test, filling_path, mass_path) for name, test in named_tests(tests).items()]
        by_seed = [
            reproduction_rows(
                geometry,
                None if filling is None else filling[filling["seed"] == seed],
                None if mass is None else mass[mass["seed"] == seed],
                recordings=self._dataset.table.index,
                protocol=self._settings.protocol,
            )
            for seed in range(self._settings.seeds)
        ]
        return Results(self._dataset, by_seed[0], tuple(by_seed[1:]), rounds, tuple(found), tuple(self._notes))

    def _step(self, name: str, share: float) -> None:
        if self._cancelled():
            raise CancelledError(STOPPED)
        self._report(name, share)

    def _means(self) -> TrainingMeans | None:
        try:
            return TrainingMeans.of(self._dataset)
        except ArgumentError as error:
            self._note(f"No fallback for failed fits: {error}")
            return None

    def _note(self, sentence: str) -> None:
        if sentence not in self._notes:
            self._notes.append(sentence)

    def _estimate_settings(self) -> EstimateSettings:
        return self._settings.estimates_with(self._means())

    def _geometry(self, dataset: Dataset, settings: EstimateSettings, *, step: str = "geometry") -> pd.DataFrame:
        """Estimates of the recordings that were filmed; the run of that name in the store is resumed."""
        self._step(step, 0.0)
        filmed = [recording.id for recording in dataset if is_filmed(recording)]
        if not filmed:
            self._note(f"{dataset.name}: no recording has a video of the method's views, so there is no geometry.")
            return pd.DataFrame({"recording_id": pd.Series(dtype="str")})
        folders = {name: str(getattr(settings, name) or "") or None for name in ("features", "sight")}
        run = make_run(
            f"reproduction {digest('run', asdict(settings) | folders)[:KEY_DIGITS]}",
            dataset,
            settings,
            store=self._store,
            recordings=filmed,
            engine=self._engine,
            progress=lambda done, total: self._step(step, done / max(1, total)),
            cancelled=self._cancelled,
        )
        if not run.is_complete:
            raise CancelledError(STOPPED)
        return run.table

    def _samples(self) -> "list[FillingSample]":
        samples = training_samples(
            self._dataset,
            self._settings,
            store=self._store,
            progress=lambda share: self._step("features", share),
            note=self._note,
        )
        if self._settings.features is not None:
            self._features = {sample.recording_id: digest(sample.features) for sample in samples}
        self._heard = digest([[getattr(sample, field.name) for field in fields(sample)] for sample in samples])
        return samples

    def _filling(self, samples: "list[FillingSample]") -> tuple[pd.DataFrame | None, pd.DataFrame | None]:
        """Predictions of the cross-validation, and those of the round with the least loss."""
        from corsmal.filling import cross_validate, folds_by_container, spread_folds  # noqa: PLC0415 - as above
        from corsmal.filling.loop import kept_epoch  # noqa: PLC0415 - as above

        self._step("filling", 0.0)
        if not samples:
            self._note("No recording has both features and an annotated filling: nothing is said about fillings.")
            return None, None
        known = self._dataset.table.loc[[sample.recording_id for sample in samples]]
        by_container = self._settings.folds == "containers"
        is_paper = self._settings.protocol == "paper"
        key = digest("filling", METHOD_VERSION, self._settings.filling, self._settings.folds, is_paper, self._heard)
        folder = self._out / "filling" / f"{self._settings.protocol}-{key[:KEY_DIGITS]}"
        try:
            folds = folds_by_container(known) if by_container else spread_folds(known)
            for note in filling_notes(known, folds):
                self._note(note)
            predictions = cross_validate(
                folder,
                samples,
                folds=folds,
                preset=self._settings.filling,
                seeds=range(self._settings.seeds),
                validation="fold" if is_paper else "inner",
                trained_on=self._filling_record,
                progress=lambda share: self._step("filling", share),
            )
        except ArgumentError as error:
            self._note(f"The filling networks could not be cross-validated: {error}")
            return None, None
        if not is_paper or self._settings.filling.keep != "best":
            return predictions, None
        first = predictions[predictions["seed"] == 0]
        losses = {
            int(fold): kept_epoch(folder / "seed0" / f"fold{fold}" / "network0")[1] for fold in first["fold"].unique()
        }
        return predictions, first[first["fold"] == min(losses, key=losses.__getitem__)]

    @cached_property
    def _filling_record(self) -> TrainedOn:
        """What the filling networks keep of their training; called once the features are there."""
        return training_record(self._dataset, features=self._features)

    @cached_property
    def _mass_record(self) -> TrainedOn:
        """What the mass networks keep of theirs, with the parameters of the dimensions."""
        return training_record(self._dataset, shape=self._settings.shape)

    def _mass_rows(self, geometry: pd.DataFrame) -> "list[MassRow]":
        ids = list(geometry["recording_id"])
        return list(
            mass_rows(
                [self._dataset[name] for name in ids],
                store=self._store,
                shape=self._settings.shape,
                progress=lambda done, total: self._step("masks", done / max(1, total)),
            )
        )

    def _mass(self, rows: "list[MassRow]") -> pd.DataFrame | None:
        """Predictions of the cross-validation, or of the paper's own split."""
        self._step("mass", 0.0)
        for note in mass_notes(rows, share=self._settings.mass.validation):
            self._note(note)
        try:
            return mass_predictions(
                rows,
                self._settings,
                self._out / "mass",
                table=self._dataset.table,
                trained_on=self._mass_record,
                progress=lambda share: self._step("mass", share),
            )
        except ArgumentError as error:
            self._note(f"The mass network could not be cross-validated: {error}")
            return None

    def _final_networks(self, samples: "list[FillingSample]", rows: "list[MassRow]") -> tuple[Path | None, Path | None]:
        """The networks that speak about test sets, trained on all recordings."""
        from corsmal.filling import train_either  # noqa: PLC0415 - loads PyTorch

        self._step("final networks", 0.0)
        settings = self._settings
        paths: list[Path | None] = []
        for kind, key, train in (
            (
                "filling",
                digest(METHOD_VERSION, settings.filling, self._heard),
                lambda place: train_either(
                    place,
                    samples,
                    training=settings.filling,
                    trained_on=self._filling_record,
                    progress=lambda share: self._step("final networks", share / 2),
                ),
            ),
            (
                "mass",
                digest(METHOD_VERSION, settings.mass, identity_of(rows)),
                lambda place: final_mass_network(rows, place, settings, trained_on=self._mass_record),
            ),
        ):
            try:
                paths.append(train(self._out / "networks" / f"{kind}-{key[:KEY_DIGITS]}"))
            except ArgumentError as error:
                self._note(f"There is no final {kind} network: {error}")
                paths.append(None)
        return paths[0], paths[1]

    def _test(self, name: str, test: Dataset, filling: Path | None, mass: Path | None) -> TestResult:
        settings = replace(
            self._estimate_settings(),
            features=self._settings.features,
            sight=self._settings.sight,
            filling=None if filling is None else find_weights("filling", filling),
            mass=None if mass is None else find_weights("mass", mass),
        )
        return TestResult(name, test, self._geometry(test, settings, step=f"test {name}"))
