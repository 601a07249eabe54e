from flycontrol.jobs.progress import Progress, no_progress


def test_work_without_a_listener_is_done_in_silence(capsys):
    progress: Progress = no_progress
    assert progress(1, 2, "roots") is None
    assert capsys.readouterr() == ("", "")
