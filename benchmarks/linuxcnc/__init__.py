"""A working day at LinuxCNC, with tool changes and faults."""
