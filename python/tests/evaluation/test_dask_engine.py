"""What c3rt campaign does around Dask; with Dask itself: tests/cli/campaign_test.py."""

import os
import signal
import subprocess
import sys
import threading

import pytest

from c3rt.evaluation.dask_engine import _deaf_children, _words_to


@pytest.fixture
def heard():
    """How often Ctrl-C was heard."""
    times = []
    before = signal.signal(signal.SIGINT, lambda *_: times.append(1))
    yield times
    signal.signal(signal.SIGINT, before)


def blocked():
    """Whether a process that is started now hears Ctrl-C."""
    words = [sys.executable, "-c", "import signal; print(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, []))"]
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout == "True\n"


def test_ctrl_c_while_workers_start_is_heard_afterwards_and_not_by_them(heard):
    found = []
    thread = threading.Thread(target=lambda: found.append(blocked()))
    with _deaf_children():
        thread.start()
        signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
        thread.join()
        assert heard == []
    assert (heard, found, blocked()) == ([1], [True], False)


def test_what_others_say_on_standard_error_goes_to_the_log_what_we_say_to_the_terminal(tmp_path, capfd):
    with _words_to(tmp_path / "dask.log"):
        os.write(2, b"of a worker\n")
        print("how far it is", file=sys.stderr)
    os.write(2, b"afterwards\n")
    assert (tmp_path / "dask.log").read_text() == "of a worker\n"
    assert capfd.readouterr().err == "how far it is\nafterwards\n"
