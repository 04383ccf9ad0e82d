"""``evaluate estimates``: what it prints and writes about a table of estimates."""

import json
from pathlib import Path

import pandas as pd
import pytest
from click.testing import Result
from typer.testing import CliRunner

import corsmal.__main__ as cli
from corsmal.evaluation import write_estimates
from tests.evaluation.made import made_annotation, perfect_estimates


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """A dataset that is only annotated, as the training set is: 684 recordings of containers 1 to 9."""
    annotation = made_annotation(684)
    counts = {number: 84 if number < 7 else 60 for number in range(1, 10)}
    annotation["container id"] = [number for number, count in counts.items() for _ in range(count)]
    annotation["filling mass"] *= 1.05  # as in the challenge, the masses are not quite level × capacity × density
    folder = tmp_path / "train"
    folder.mkdir()
    (folder / "annotation.json").write_text(json.dumps({"annotations": annotation.to_dict("records")}))
    return folder


@pytest.fixture
def estimates() -> pd.DataFrame:
    return perfect_estimates(made_annotation(684))


def evaluated(root: Path, estimates: pd.DataFrame, *options: object) -> Result:
    write_estimates(estimates, root.parent / "estimates.csv")
    command = ["evaluate", "estimates", str(root), str(root.parent / "estimates.csv"), *map(str, options)]
    return CliRunner().invoke(cli.app, command)


def score(result: Result, name: str) -> float:
    return float(next(line.split()[1] for line in result.stdout.splitlines() if line.startswith(f"{name} ")))


def test_the_set_is_found_and_said_and_can_be_named(root, estimates):
    result = evaluated(root, estimates)
    assert "684 of 684 recordings\nScored as the challenge's training set, because" in result.stdout
    other = evaluated(root, estimates, "--split", "other")
    assert "Scored as a set that is none of the challenge's, because --split names it." in other.stdout
    assert score(result, "s8") - score(other, "s8") == pytest.approx(4.75, abs=0.06)


def test_real_perfect_table_scores_100_and_75(real_dataset_root, tmp_path):
    estimates = perfect_estimates(pd.read_csv(real_dataset_root / "ccm_train_annotation.csv"))
    write_estimates(estimates, tmp_path / "estimates.csv")
    command = ["evaluate", "estimates", str(real_dataset_root), str(tmp_path / "estimates.csv")]
    result = CliRunner().invoke(cli.app, command)
    assert score(result, "s8") == 100
    assert score(result, "overall") == 75


def test_a_part_is_scored_as_a_part_and_by_the_challenges_rule_when_wanted(root, estimates):
    part = evaluated(root, estimates[:1])
    assert "(held-out), 1 of 684 recordings\n" in part.stdout
    assert "683 have none and are not scored" in part.output
    assert score(part, "overall") == 75
    whole = evaluated(root, estimates[:1], "--absent", "zero")
    assert "684 of 684 recordings" in whole.stdout
    assert score(whole, "s3") == pytest.approx(0.1)


def test_what_a_network_was_trained_on_is_left_out_and_said(root, estimates):
    trained = estimates.assign(mass_held_out=False)
    result = evaluated(root, trained)
    assert (
        "Mass: 684 of 684 recordings are left out (protocol held-out): the network was trained on them" in result.output
    )
    assert "there is no overall score, because no recording can be scored in s7" in result.output
    shown = evaluated(root, trained, "--protocol", "in-sample", "--out", root.parent / "table.tex")
    assert "By container (in-sample)" in shown.stdout
    assert "must not be published as results" in shown.output
    assert (root.parent / "table.tex").read_text(encoding="utf-8").startswith("% In-sample: ")


@pytest.mark.parametrize("ending", ["tex", "csv", "html", "md"])
def test_a_column_group_per_protocol_goes_into_the_file(root, estimates, ending):
    out = root.parent / f"table.{ending}"
    result = evaluated(root, estimates, "--protocol", "held-out", "--protocol", "paper", "--out", out)
    assert result.exit_code == 0, result.output
    text = out.read_text(encoding="utf-8")
    if ending == "csv":
        assert pd.read_csv(out)["protocol"].unique().tolist() == ["held-out", "paper"]
    else:
        assert "Held-out" in text
        assert "Paper" in text
        assert "Published" in text
    assert result.stdout.count("By container") == 2


def test_what_cannot_be_is_refused_in_a_sentence(root, estimates):
    wrong = evaluated(root, estimates, "--out", root.parent / "table.xlsx")
    assert wrong.exit_code == 2
    assert ".csv, .tex, .html" in " ".join(wrong.output.replace("│", " ").split())
    unknown = evaluated(root, estimates, "--protocol", "best")
    assert "protocol must be one of held-out, paper, in-sample, got 'best'" in str(unknown.exception)
