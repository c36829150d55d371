"""The laboratory of moireid: what prints the project's figures.  It may import moireid and the studio.

baseline/    the published pipeline, to compare ours with
archive/     many films, each by itself, on Dask
evaluation/  labelled collections: scores, statistics, plots
bench/       suites that print the project's figures
commands/    moireid lab bench, evaluate, film-set, generator-kit
"""
