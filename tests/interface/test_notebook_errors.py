"""A notebook shows errors by their message and the lines of its own cells."""

from __future__ import annotations

from pathlib import Path

import pytest

import rolling as rc
from rolling.terminal.notebook import Interrupted


def scene_of_nobody() -> rc.Scene:
    return rc.read_scene("quikstart")


@pytest.mark.parametrize("kind", [rc.SceneError, rc.FolderError, rc.ContactError, Interrupted])
def test_errors_that_a_person_can_mend_have_a_text_for_notebooks(kind: type) -> None:
    assert callable(kind._render_traceback_)


def test_the_text_has_the_lines_of_the_person_and_the_message(tmp_path: Path) -> None:
    with pytest.raises(rc.SceneError) as caught:
        scene_of_nobody()
    first, second, message = caught.value._render_traceback_()
    assert first.endswith("scene_of_nobody()")
    assert second.endswith('return rc.read_scene("quikstart")')
    assert message == f"SceneError: {caught.value}"
