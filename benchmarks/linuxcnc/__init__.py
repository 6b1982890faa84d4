"""A working day at LinuxCNC, simulated: faults, tool changes, and axes that hold the nose still."""
