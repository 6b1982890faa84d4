"""A second machine to test the gap finder on: belt-driven, greased, uncooled, in an enclosure.

It shares nothing with ``plant_model`` and no physics with the first one, ``benchmarks.gap.truth``:
finite elements, own laws, own numbers, own tests. Its owner writes a page for every case, with
numbers as far off as their source allows and sometimes a mistake.
"""
