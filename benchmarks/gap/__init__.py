"""The gap finder's benchmark: cases from independent simulators, answers, tables."""
