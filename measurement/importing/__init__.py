"""From anybody's log to run files: tables as recorders and spreadsheets write them.

``sheets`` reads a file into ``cells``, ``headers`` and ``quantities`` say what each column is,
``clock`` makes time of it, ``joining`` puts tables on one clock, ``splitting`` cuts a long log into
runs, and ``mapping`` keeps what was decided.
``log.import_files`` does all of it.
"""
