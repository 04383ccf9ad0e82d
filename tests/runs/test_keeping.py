import os
from dataclasses import replace

import pytest

from corsmal.errors import ArgumentError, FileError
from corsmal.runs import (
    delete_run,
    deleted_runs,
    label_run,
    list_runs,
    load_run,
    make_run,
    restore_run,
)
from corsmal.runs.keeping import DAY_S, DELETED, DELETED_KEPT_DAYS
from corsmal.runs.run import LABELS, save_run


def names(store):
    return [found.name for found in list_runs(store=store)]


def test_a_renamed_run_keeps_its_id_rows_and_what_was_computed_from_it(run, dataset, store):
    renamed = label_run(run, store=store, name="  second try ")
    found = load_run("second try", dataset=dataset.root, store=store)
    assert (renamed.name, found.name) == ("second try", "second try")
    assert (found.id, found.key, found.rows) == (run.id, run.key, run.rows)
    assert load_run("first", dataset=dataset.root, store=store) is None


def test_a_run_that_is_being_made_can_be_renamed(dataset, settings, store):
    def rename(done, _total):
        if done == 1:
            label_run(list_runs(store=store)[0], store=store, name="mine", note="while it is made")

    make_run("first", dataset, settings, store=store, progress=rename)
    [found] = list_runs(store=store)
    assert (found.name, found.note, found.is_complete) == ("mine", "while it is made", True)
    again = make_run("first", dataset, settings, store=store)
    assert again.id != found.id
    assert sorted(names(store)) == ["first", "mine"]


def test_note_and_archive_are_kept_and_may_be_taken_back(run, store):
    label_run(run, store=store, note=" <b>wall</b> of 1 mm\nsecond line ")
    label_run(run, store=store, is_archived=True)
    [found] = list_runs(store=store)
    assert (found.note, found.is_archived, found.name) == ("<b>wall</b> of 1 mm\nsecond line", True, "first")
    label_run(found, store=store, note="", is_archived=False)
    [found] = list_runs(store=store)
    assert (found.note, found.is_archived) == ("", False)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("  ", "a run needs a name of 1 to 60 characters"),
        ("x" * 61, "at most 60 characters, got 61"),
        ("other", "the name 'other' is taken by another run on this dataset"),
        ("<script>alert(1)</script>", "begins with a letter or digit and holds letters, digits, spaces"),
        ("a [link](http://x)", "begins with a letter or digit"),
        ("a\nb", "begins with a letter or digit"),
        ("=1+1", "begins with a letter or digit"),
        ("../up", "begins with a letter or digit"),
        (":red[x]", "begins with a letter or digit"),
    ],
)
def test_a_bad_name_is_one_sentence_and_changes_nothing(run, store, name, said):
    save_run(replace(run, name="other", id=""), store=store)
    with pytest.raises(ArgumentError, match=said) as caught:
        label_run(run, store=store, name=name, note="not kept")
    assert "\n" not in str(caught.value)
    assert sorted(names(store)) == ["first", "other"]
    assert all(found.note == "" for found in list_runs(store=store))


def test_a_run_is_begun_under_a_good_name_only_and_one_with_an_old_name_is_still_resumed(run, dataset, settings, store):
    with pytest.raises(ArgumentError, match="begins with a letter or digit"):
        make_run("*new*", dataset, settings, store=store)
    old = replace(run, name="*old*", id="", rows=run.rows[:1])
    save_run(old, store=store)
    assert make_run("*old*", dataset, settings, store=store).id == old.id


def test_a_note_that_is_too_long_is_refused(run, store):
    with pytest.raises(ArgumentError, match="at most 500 characters, got 501"):
        label_run(run, store=store, note="x" * 501)


def test_a_label_that_cannot_be_kept_is_an_error(run, blocked):
    with pytest.raises(FileError, match="could not be kept"):
        label_run(run, store=blocked, note="x")


def test_a_broken_label_leaves_the_run_under_its_first_name(run, store):
    label_run(run, store=store, name="second")
    store.file(LABELS, run.id, ".json").write_bytes(b"{")
    assert names(store) == ["first"]


def test_a_deleted_run_comes_back_as_it_was(run, store):
    run = label_run(run, store=store, name="mine", note="keep me")
    for _ in range(2):
        delete_run(run, store=store)
        assert list_runs(store=store) == []
    [deleted] = deleted_runs(store=store, dataset=run.dataset)
    assert (deleted.run.name, deleted.run.id, deleted.run.rows) == ("mine", run.id, run.rows)
    assert deleted_runs(store=store, dataset="/elsewhere") == []
    restored = restore_run(deleted.run, store=store)
    [found] = list_runs(store=store)
    assert (restored.name, found.name, found.note, found.id) == ("mine", "mine", "keep me", run.id)
    assert deleted_runs(store=store) == []


def test_a_run_whose_name_was_taken_meanwhile_gets_a_number(run, dataset, settings, store):
    delete_run(run, store=store)
    other = make_run("first", dataset, settings, store=store)
    assert other.id != run.id
    assert restore_run(run, store=store).name == "first 2"
    assert sorted(names(store)) == ["first", "first 2"]


def test_what_was_deleted_a_month_ago_is_removed_for_good(run, store):
    second = replace(run, name="second", id="")
    save_run(second, store=store)
    label_run(run, store=store, note="old")
    delete_run(run, store=store)
    path = store.file(DELETED, run.id, ".json")
    long_ago_s = path.stat().st_mtime - DELETED_KEPT_DAYS * DAY_S - 1
    os.utime(path, (long_ago_s, long_ago_s))
    delete_run(second, store=store)
    assert [deleted.run.name for deleted in deleted_runs(store=store)] == ["second"]
    assert not store.file(LABELS, run.id, ".json").exists()


def test_a_run_that_was_made_on_after_it_was_deleted_is_not_undone(run, store):
    delete_run(replace(run, rows=run.rows[:1]), store=store)
    save_run(run, store=store)
    restore_run(run, store=store)
    assert list_runs(store=store)[0].rows == run.rows
