"""Two candidates in the noise of a room: the verdict in words, and why there may be none."""

from __future__ import annotations

import numpy as np
import pytest

import acoustics
import rolling as rc
from rolling.scene.identity import contact_keys
from rolling.sound.heard_in_room import HeardRecord, heard_difference

RATE = 48000


def tone(level_db, frequency_hz=1000.0):
    amplitude = np.sqrt(2.0) * acoustics.P_REF_PA * 10.0 ** (level_db / 20.0)
    pressure = amplitude * np.sin(2.0 * np.pi * frequency_hz * np.arange(4800) / RATE)
    return HeardRecord(pressure, RATE, closed=True)


@pytest.mark.slow
def test_the_sentence_names_the_louder_candidate():
    heard = heard_difference([tone(20.0)], [tone(40.0)], names=("lapped", "ground"))
    assert heard.audibility is not None and heard.audibility.verdict == "audible"
    assert heard.audibility.difference_percent < 0.0
    assert "is audible" in heard.text and "N5 of ground is" in heard.text


@pytest.mark.slow
def test_a_loud_room_masks_both():
    room = {"1000": 60.0, "2000": 60.0}
    heard = heard_difference([tone(20.0)], [tone(40.0)], room_db=room)
    assert heard.audibility is not None and heard.audibility.verdict == "not audible"
    assert "not audible" in heard.text and "masks both" in heard.text


def test_too_loud_a_sound_has_no_verdict():
    heard = heard_difference([tone(130.0, 100.0)], [tone(40.0)])
    assert heard.audibility is None and "120 dB" in heard.text


def test_unpaired_records_are_refused():
    with pytest.raises(ValueError, match="got 2 of A and 1 of B"):
        heard_difference([tone(20.0), tone(20.0)], [tone(40.0)])


# ---- the key of the scene


def quickstart():
    return rc.read_scene("scenarios/quickstart.yaml")


def test_the_room_changes_no_contact_and_stays_in_the_scene():
    scene = quickstart()
    changed = scene.with_({"sound.room_db": {125: 22, 31.5: 40}})
    assert contact_keys(changed) == contact_keys(scene)
    assert changed.sound.room_db == {"31.5": 40.0, "125": 22.0}
    assert rc.Scene.from_dict(changed.to_dict()) == changed
    assert "room_db" not in scene.to_dict()["sound"]


def test_the_check_states_the_level_of_the_room():
    # 30 dB at 1 kHz alone, where the weighting is zero.
    scene = quickstart().with_({"sound.room_db": {1000: 30}, "sweep": {}})
    findings = {finding.quantity: finding.value for finding in scene.check(solve=False)}
    assert findings["room noise"] == "30 dB(A)"
    assert "room noise" not in {row.quantity for row in quickstart().check(solve=False)}


@pytest.mark.parametrize(
    ("room", "message"),
    [
        ({1100: 20}, r"got the frequency 1100, .*nearest: 1000"),
        ({63: 130}, r"63 Hz: got 130, allowed: a level from -20 to 120 dB"),
        ({63: "loud"}, r"63 Hz: got \"loud\""),
        ({}, r"got \{\}, allowed: levels in dB by nominal mid frequency"),
        (30, r"got 30, allowed: levels in dB by nominal mid frequency"),
        ({"low": 30}, r"got the frequency \"low\""),
        ({float("inf"): 30}, r"got the frequency .inf, .*nearest: 20000"),
    ],
)
def test_rooms_that_are_not_allowed_are_refused(room, message):
    with pytest.raises(rc.SceneError, match=rf"sound\.room_db: {message}"):
        quickstart().with_({"sound.room_db": room})
