"""Claims: QoS survives its text, old and new, and is joined so that all match."""

from __future__ import annotations

import pytest

from arjuna_core.bags.topic import TopicQos, dump, offer_for, parse, request_for

STRONG, WEAK = TopicQos(latched=True, depth=1), TopicQos(reliable=False, depth=5)


def test_profiles_survive_their_text() -> None:
    assert parse(dump([STRONG, WEAK])) == (STRONG, WEAK)


def test_the_numbers_of_old_recordings_are_understood() -> None:
    text = "- {history: 1, depth: 1, reliability: 1, durability: 1}\n- {reliability: 2, depth: 5}"
    assert parse(text) == (STRONG, WEAK)


@pytest.mark.parametrize("text", ["", "{", "7", "- 7"])
def test_what_cannot_be_read_is_left_out(text: str) -> None:
    assert parse(text) == ()


def test_a_request_matches_the_weakest_and_an_offer_the_strongest() -> None:
    assert request_for([STRONG, WEAK]) == TopicQos(reliable=False, latched=False)
    assert request_for([STRONG]) == TopicQos(reliable=True, latched=True)
    assert offer_for([STRONG, WEAK]) == TopicQos(reliable=True, latched=True, depth=5)
    assert offer_for([]) == TopicQos(reliable=True, latched=False, depth=100)
    assert offer_for([STRONG], publishers=100).depth == 100
