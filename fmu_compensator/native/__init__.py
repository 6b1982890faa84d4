"""The compensator as a C99 FMU: the C twin of the runtime, and the code that builds the FMU."""
