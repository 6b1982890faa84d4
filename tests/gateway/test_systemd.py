"""What a service manager hears."""

import os
import socket
from math import inf

import pytest

from gateway.systemd import ServiceManager


@pytest.mark.parametrize("abstract", [False, True])
def test_it_hears_what_it_is_told(tmp_path, abstract):
    name = f"spindle-drift-{os.getpid()}" if abstract else str(tmp_path / "notify")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind("\0" + name if abstract else name)
        manager.settimeout(5.0)
        told = {"NOTIFY_SOCKET": "@" + name if abstract else name, "WATCHDOG_USEC": "2000000"}
        service = ServiceManager(told)
        service.tell("READY=1", "STATUS=valid")
        assert manager.recv(100) == b"READY=1\nSTATUS=valid"
        for now in (0.0, 0.5, 0.99, 1.0, 1.5, 2.0):
            service.alive(now)
        service.tell("STOPPING=1")
        assert [manager.recv(100) for _ in range(4)] == [b"WATCHDOG=1"] * 3 + [b"STOPPING=1"]


@pytest.mark.parametrize(
    ("told", "every_s"),
    [
        ({}, inf),
        ({"WATCHDOG_USEC": "10000000"}, 5.0),
        ({"WATCHDOG_USEC": "10000000", "WATCHDOG_PID": str(os.getpid())}, 5.0),
        ({"WATCHDOG_USEC": "10000000", "WATCHDOG_PID": "1"}, inf),
        ({"WATCHDOG_USEC": "soon"}, inf),
    ],
)
def test_signs_of_life_come_twice_as_often_as_asked_for(told, every_s):
    assert ServiceManager(told).every_s == every_s


def test_without_a_manager_nothing_is_told(tmp_path):
    ServiceManager({}).tell("READY=1")
    ServiceManager({"NOTIFY_SOCKET": str(tmp_path / "nobody")}).tell("READY=1")
