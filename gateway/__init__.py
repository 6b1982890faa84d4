"""The compensator on a CAN bus: frames, both ends, and what happens when something is wrong.

Frames and signals come from a DBC file, of the gateway's own form (``dbc``) or by a map
(``mapping``). ``codec`` makes frames, ``reception`` and ``judging`` judge what arrives, ``link``
connects to the bus, ``node`` is the gateway, ``machine`` the control at the other end,
``protocols`` and ``controls`` are ports, ``linuxcnc`` is a real control.
"""
