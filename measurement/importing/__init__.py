"""Imports run files from logs of any recorder and from spreadsheets.

``sheets`` reads a file into ``cells``, ``headers`` and ``quantities`` identify the columns,
``clock`` reads the time, ``joining`` puts tables on one clock, ``splitting`` cuts a long log into
runs, and ``mapping`` stores the decisions. ``log.import_files`` runs all steps.
"""
