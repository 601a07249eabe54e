import json
from pathlib import Path

import numpy as np
import pytest
from lab_note import lab_note

from flycontrol.units import deg, ms

ANALYSES = Path(__file__).resolve().parents[2] / "analyses"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def results(real_data, tmp_path_factory):
    """The lab note's findings and the folder that it wrote."""
    note = lab_note("turn_angle_from_paddling")
    note.DATA = real_data
    folder = tmp_path_factory.mktemp("turn_angle_from_paddling")
    return note.main(folder), folder


def test_turns_of_a_fly_that_only_yaws_follow_the_slope_and_the_cosine_in_drag(results):
    """Within 0.5 % of the torque's own departure from its straight line at the amplitude of the paddling."""
    found, _ = results
    curve = found.paddled
    assert len(found.turns) >= 10
    for turn in found.turns:
        straight = np.interp(abs(turn.amplitude), curve.inputs, curve.torque / (curve.slope * curve.inputs))
        assert straight - 0.005 < found.share(turn, turn.tethered) < 1.005


def test_a_turn_to_the_left_is_the_mirror_image_of_one_to_the_right(results):
    found, _ = results
    by_bump = {(round(t.amplitude / deg), t.length): t for t in found.turns}
    for bump in ((3, 6), (2, 10)):
        right, left = by_bump[bump], by_bump[(-bump[0], bump[1])]
        assert left.tethered == pytest.approx(-right.tethered, rel=1e-9)
        assert left.flying == pytest.approx(-right.flying, rel=1e-6)


def test_a_turn_read_as_a_recording_lies_within_the_whole_turn(results):
    found, _ = results
    for turn in found.turns:
        assert 0.85 < turn.windowed.angle / turn.tethered < 1.0
        assert turn.windowed.complete


def test_the_kicked_fly_keeps_to_the_reduced_model(results):
    found, _ = results
    for stroke in found.strokes:
        assert stroke.decay.half_life == pytest.approx(stroke.model.half_life, rel=0.005)
        assert stroke.gain.product == pytest.approx(stroke.gain.ratio, rel=1e-12)


def test_the_note_states_the_numbers_that_it_finds(results):
    found, folder = results
    text = " ".join((ANALYSES / "turn_angle_from_paddling.py").read_text(encoding="utf-8").replace("\n#", " ").split())
    shares = [found.share(t, t.tethered) for t in found.turns]
    flown = [found.share(t, t.flying) for t in found.turns]
    read = [t.windowed.angle / t.windowed.by_wing_speed for t in found.turns]
    angles = [abs(t.tethered) / deg for t in found.turns]
    gains = [stroke.gain for stroke in found.strokes]
    hover, fry, _ = found.strokes
    real = [t.turn.angle / deg - t.slope * t.turn.by_wing_speed / deg for t in found.real]
    last = [gain["pitch"].alone for gain in gains[1:]]
    sentences = (
        f"within {1 - min(shares):.1%}, at {gains[0].over_wing_speed:.3f} omega".replace("%", " %"),
        f"Over {len(shares)} turns of {min(angles):.0f} to {max(angles):.0f} deg",
        f"{min(shares):.3f} to {max(shares):.3f} of gamma/beta",
        f"by 5 % at {found.paddled.linear_range / deg:.1f} deg",
        f"banks by up to {max(t.tilt for t in found.turns) / deg:.0f} deg",
        f"{min(flown):.2f} to {max(flown):.2f} of the same product",
        f"{min(read):.2f} to {max(read):.2f} omega",
        f"their slope by {np.sqrt(np.mean(np.square(real))):.0f} deg rms",
        f"({gains[2].over_wing_speed:.3f})",
        f"gives {spread(gains, 'waveform')}",
        f"to the side {spread(gains, 'hinge to the side')}",
        f"square wave {spread(gains, 'pitch')}",
        f"deviation {spread(gains, 'deviation')}",
        f"is {min(g.drag_slope for g in gains):.3f} to {max(g.drag_slope for g in gains):.3f}",
        f"after {hover.decay.half_life / ms:.2f} ms, {hover.decay.in_wingbeats:.2f} wingbeats",
        f"after {fry.decay.half_life / ms:.2f} ms",
        f"says {hover.model.half_life / ms:.2f} and {fry.model.half_life / ms:.2f} ms",
        f"it is {found.flying.half_life / ms:.2f} ms",
        f"from {found.springs.given.damping:.3g} to {found.springs.passive.damping:.3g} N m s",
        f"{1 - found.springs.passive.damping / 21e-12:.0%} below".replace("%", " %"),
        f"{found.springs.decay.late_half_life / ms:.2f} ms once the pitch has followed",
        f"own beta says {found.springs.passive.half_life / ms:.2f} ms",
        f"already, pitch is {min(last):.2f} to {max(last):.2f}",
    )
    assert [sentence for sentence in sentences if sentence not in text] == []
    small = [abs(g[n].factor - 1) for g in gains for n in ("rotational force", "added mass", "dissipative torque")]
    assert max(small) < 0.021
    assert hover.model.inertia.free / hover.model.inertia.total == pytest.approx(2 / 3, abs=0.02)
    numbers = json.loads((folder / "turn_angle_from_paddling.json").read_text(encoding="utf-8"))
    assert len(numbers["simulated_turns_deg"]) == len(found.turns)
    assert (folder / "turn_angle_from_paddling.svg").stat().st_size < 300_000
    assert sorted(path.suffix for path in folder.iterdir()) == [".json", ".md", ".svg"]


def spread(gains, name: str) -> str:
    values = [gain[name].factor for gain in gains]
    return f"{min(values):.2f} to {max(values):.2f}"
