import pytest

from flycontrol.errors import InvalidInputError
from flycontrol.io.frame_ranges import frame_range


def test_the_last_frame_named_is_included():
    assert list(frame_range("2:6:2", 10)) == [2, 4, 6]
    assert list(frame_range(":3", 10)) == [0, 1, 2, 3]
    assert list(frame_range("8:", 10)) == [8, 9]
    assert frame_range(None, 10) == frame_range("::1", 10) == range(10)


@pytest.mark.parametrize("text", ["", "3", "a:b", "5:4", "0:10", "0:5:0", "-1:5", "1:2:3:4"])
def test_a_range_that_names_no_frames_of_the_film_is_refused(text):
    with pytest.raises(InvalidInputError, match="--frames is"):
        frame_range(text, 10)
