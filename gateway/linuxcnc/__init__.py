"""LinuxCNC as the control: its axes move by the offsets that the compensator asks for."""
