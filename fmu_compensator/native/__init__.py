"""The compensator as a C99 FMU: the runtime's twin without Python, and what makes an FMU of it."""
