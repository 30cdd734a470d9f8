"""Processes that work for a benchmark leave Ctrl-C to the one that started them."""

from __future__ import annotations

import os
import signal
import threading

from serpenoid.bench.child_process import Limited


def test_a_limited_child_does_not_hear_ctrl_c() -> None:
    before = signal.getsignal(signal.SIGINT)
    with Limited() as child:
        pid = child(20.0, os.getpid)
        os.kill(pid, signal.SIGINT)
        assert child(20.0, os.getpid) == pid
    assert signal.getsignal(signal.SIGINT) is before


def test_children_can_be_started_beside_the_main_thread() -> None:
    answers: list[int] = []

    def work() -> None:
        with Limited() as child:
            answers.append(child(20.0, int))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert answers == [0]
