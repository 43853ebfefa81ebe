"""Notes on what is simulated otherwise than its file says."""

from __future__ import annotations

from arjuna_sim.model.notes import Note, NoteKind, gathered


def _gathered(*lines: str) -> tuple[str, ...]:
    return gathered(Note(NoteKind.MISSING, line) for line in lines)


def test_what_is_said_of_several_links_is_one_line() -> None:
    few = [f"link '{name}' visual: mesh 'a.stl' does not exist" for name in "abcd"]
    assert _gathered(*few) == ("link 'a', 'b', 'c', 'd' visual: mesh 'a.stl' does not exist",)
    assert _gathered(*few, few[0].replace("'a'", "'e'")) == (
        "link 'a', 'b', 'c' and 2 more visual: mesh 'a.stl' does not exist",
    )


def test_what_differs_stays_apart_and_in_order() -> None:
    lines = (
        "link 'a': is heavy",
        "plugin 'x': not simulated",
        "plugin 'y': not simulated",
        "joint 'a': is heavy",
        "link 'a': is light",
    )
    assert _gathered(*lines) == lines


def test_actors_are_gathered_too() -> None:
    walkers = [f"actor 'a{i}': an upright cylinder stands for its skin" for i in range(10)]
    said = "actor 'a0', 'a1', 'a2' and 7 more: an upright cylinder stands for its skin"
    assert _gathered(*walkers) == (said,)
