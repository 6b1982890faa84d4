"""LinuxCNC as the control, which moves its axes by the compensator's offsets."""
