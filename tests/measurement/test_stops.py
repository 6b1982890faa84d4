"""Signals while other processes work."""

import signal
import threading

import pytest

from measurement.stops import ending_work


def test_a_wait_is_ended_before_anything_is_raised():
    waited_for, reached = threading.Event(), []
    usual = signal.getsignal(signal.SIGINT)
    timer = threading.Timer(0.2, signal.raise_signal, [signal.SIGINT])

    def work() -> None:
        with ending_work(waited_for.set):
            timer.start()
            waited_for.wait()
            reached.append("after the wait")

    with pytest.raises(KeyboardInterrupt):
        work()
    timer.join()
    assert reached
    # Whoever waits for the same later finds its lock free.
    assert waited_for.wait(0.0)
    assert signal.getsignal(signal.SIGINT) is usual


def test_work_of_its_own_is_interrupted_at_once():
    ended, reached = [], []

    def work() -> None:
        with ending_work(lambda: ended.append(1)):
            signal.raise_signal(signal.SIGINT)
            reached.append("after the signal")

    with pytest.raises(KeyboardInterrupt):
        work()
    assert not reached
    assert ended == [1]


def test_a_signal_without_a_function_keeps_its_usual_way():
    usual = signal.signal(signal.SIGTERM, signal.SIG_IGN)
    try:
        with ending_work(lambda: pytest.fail("nothing was to be ended")):
            signal.raise_signal(signal.SIGTERM)
            assert signal.getsignal(signal.SIGTERM) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGTERM, usual)


def test_other_threads_are_left_alone():
    seen = []

    def work() -> None:
        usual = signal.getsignal(signal.SIGINT)
        with ending_work(lambda: None):
            seen.append(signal.getsignal(signal.SIGINT) is usual)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [True]
